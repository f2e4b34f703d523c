"""The deflection that the reference motion causes by itself. The end-point feedback acts on what is measured beyond it.

Fed back whole, the deflection that a move needs would slow the joint down, and a command filter would have to be made for a mode
that is slower the more the joint gives way: the linear model says 0.70 of the clamped frequency with gain 1, stuck friction 1.0, trials
about 0.8. With the expected deflection taken off, a move that goes as planned sees no feedback: the link answers as if clamped to
the reference, and command filters are made for its own frequency.

Where the reference rests nothing is expected, so whatever is left of the model's own vibration fades: what the link then does is damped.
"""

from __future__ import annotations

from config.schema.rig import LinkMode
from servo_control.link.link_mode import LinkFrequency
from servo_control.link.link_motion import carried_arm, one_period

REST_RAD_PER_S = 1e-5
FADE_S = 0.05


class ExpectedDeflection:
    """One `step` a cycle while the servo is engaged; plain floats."""

    __slots__ = ("_frequency", "_keep", "_link", "_period_s", "_state")

    def __init__(self, link: LinkMode, period_s: float) -> None:
        self._link, self._period_s = link, period_s
        self._frequency = LinkFrequency(link)
        self._keep = 1.0 - period_s / max(FADE_S, period_s)
        self._state = (0.0, 0.0)

    def reset(self) -> None:
        """Straight link, at rest."""
        self._state = (0.0, 0.0)

    def step(self, extension_m: float, extension_rate: float, reference_rate: float) -> float:
        """Deflection in m to be expected now; `reference_rate` (rad/s) of the rotary joint, extension and its rate in m and m/s."""
        omega = self._frequency.omega_d(extension_m)
        carried = carried_arm(self._link, extension_m) * reference_rate
        drag = 2.0 * self._link.damping_ratio * omega
        w, v = one_period(self._state, omega, drag, carried, extension_rate * reference_rate, self._period_s)
        if -REST_RAD_PER_S < reference_rate < REST_RAD_PER_S:
            w, v = self._keep * w, self._keep * v
        self._state = (w, v)
        return w

    def snapshot(self) -> list[float]:
        return list(self._state)

    def restore(self, state: list[float]) -> None:
        self._state = (state[0], state[1])
