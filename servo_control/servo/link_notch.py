"""A notch at the link's own frequency between measured position and rotary servo, where the link is fast.

    e − s · b,    b = 2 ω p/(p + ω)² · e:    with s = 1 (p² + ω²)/(p + ω)²

A link without payload has 15 to 40 Hz and hardly any damping: what little noise of the encoder the valve passes on at that frequency
shakes it all the time. The servo's own loop is far slower and can do without. State variable filter with trapezoidal integrators
(V. Zavalishin, The Art of VA Filter Design, 2012): it stays stable while ω follows the extension.
"""

from __future__ import annotations

from math import isfinite, pi, tan
from typing import Any

from config.schema.rig import LinkMode, Rig
from config.schema.servo import LinkNotchRange, RotaryServo
from servo_control.link.link_mode import LinkFrequency
from servo_control.numerics.limits import clamp

STEEPEST = 1.2  # of ω T/2, below the π/2 of half the sampling rate


def link_notch(rig: Rig) -> LinkNotch | None:
    """Of the rig's rotary joint; None where the rig file asks for none."""
    servo = rig.servo.get("rotary")
    if not isinstance(servo, RotaryServo) or servo.link_notch is None or rig.link_mode is None:
        return None
    return LinkNotch(servo.link_notch, rig.link_mode, rig.joints["prismatic"].travel, 1.0 / rig.loop.rate_Hz)


class LinkNotch:
    """`follow` and then `step` once a cycle; plain floats."""

    __slots__ = ("_band", "_frequency", "_half_period_s", "_low", "_settings", "_share", "_slope", "_travel")

    def __init__(self, settings: LinkNotchRange, link: LinkMode, travel: tuple[float, float], period_s: float) -> None:
        """`travel` of the prismatic joint (m): a broken sample of the extension must not become a frequency."""
        self._settings, self._travel = settings, travel
        self._frequency = LinkFrequency(link)
        self._half_period_s = 0.5 * period_s
        self._share = self._slope = 0.0
        self.reset()

    def reset(self) -> None:
        """As if the error had been 0 for long."""
        self._band = self._low = 0.0

    def follow(self, extension_m: float) -> None:
        """Take the frequency for this extension (m); it stays where the extension is not known."""
        if not isfinite(extension_m):
            return
        omega = self._frequency.omega_d(clamp(extension_m, *self._travel))
        begin, end = self._settings.none_below_Hz, self._settings.full_above_Hz
        self._share = clamp((omega / (2.0 * pi) - begin) / (end - begin), 0.0, 1.0)
        self._slope = tan(min(omega * self._half_period_s, STEEPEST)) if self._share > 0.0 else 0.0

    def step(self, error: float) -> float:
        """One cycle: the error without its part at the link's frequency."""
        if self._share == 0.0:
            self.reset()
            return error
        g = self._slope
        band = (self._band + g * (error - self._low)) / (1.0 + g * (2.0 + g))
        low = self._low + g * band
        self._band, self._low = 2.0 * band - self._band, low + g * band
        return error - 2.0 * self._share * band

    def snapshot(self) -> dict[str, Any]:
        return {"band": self._band, "low": self._low}

    def restore(self, state: dict[str, Any]) -> None:
        self._band, self._low = state["band"], state["low"]
