"""Feed-forward after the measured oil temperature: thin oil leaks more while the same friction has to be overcome.
(C3) of docs/method/control.md, and what the feedback asks for.

    u = k_ff · f(T) · v + s(T) · [c + (1 − |c|) · clamp(push, share)] + b(T),    c = clamp(v / v_full)

f, s, b: tables over T, which is low-passed; f has a value for either direction; v: the reference's rate; push: what a feedback asks
for, see `servo_control.link.end_point`.

A lost sample keeps the last temperature; before the first one nothing is compensated.
"""

from __future__ import annotations

from math import exp, isfinite
from typing import Any

from config.schema.oil_compensation import LinearOilCompensation, OilPoint, RotaryOilCompensation
from config.schema.rig import Rig
from servo_control.numerics.limits import clamp
from servo_control.numerics.table import between


def temperature_signals(rig: Rig) -> tuple[str | None, ...]:
    """The signal that compensates every joint, in the order of the joints; None for a joint without compensation."""
    settings = (rig.servo[joint].oil_compensation for joint in rig.joints)
    return tuple(each.source if each is not None else None for each in settings)


class OilCompensation:
    """One joint's table. `measure` once a cycle, then `volts` and `bias_V`."""

    __slots__ = ("_feedback_share", "_full_rate", "_points", "_share", "_temperatures", "_values", "largest_bias_V", "temperature_C")

    def __init__(self, settings: RotaryOilCompensation | LinearOilCompensation, velocity_feedforward: float, period_s: float) -> None:
        self._temperatures = [point.temperature_C for point in settings.points]
        self._points = [
            (
                (point.velocity_factor - 1.0) * velocity_feedforward,
                (_back(point) - 1.0) * velocity_feedforward,
                point.friction_V,
                point.bias_V,
            )
            for point in settings.points
        ]
        self._full_rate = settings.friction_rate
        self._feedback_share = settings.feedback_share
        self._share = 1.0 - exp(-period_s / settings.filter_s)
        self.largest_bias_V = max(abs(point.bias_V) for point in settings.points)
        self.temperature_C: float | None = None
        self._values = (0.0, 0.0, 0.0, 0.0)

    @property
    def bias_V(self) -> float:
        return self._values[3]

    def measure(self, temperature_C: float) -> None:
        """This cycle's sample; NaN where it was lost."""
        if not isfinite(temperature_C):
            return
        before = temperature_C if self.temperature_C is None else self.temperature_C
        self.temperature_C = before + self._share * (temperature_C - before)
        self._values = self._at(self.temperature_C)

    @property
    def friction_V(self) -> float:
        """At the temperature measured."""
        return self._values[2]

    def volts(self, reference_rate: float, push: float = 0.0) -> float:
        """Added to the command for this reference rate (rad/s or m/s). `push`: share of the friction that a feedback wants to have
        overcome, with its sign; it is limited here, and gives way to the reference, the more the faster that moves.
        """
        forth, back, friction, _ = self._values
        direction = clamp(reference_rate / self._full_rate, -1.0, 1.0)
        slope = forth if reference_rate >= 0.0 else back  # nothing jumps: at rest both make 0 V
        volts = slope * reference_rate + friction * direction
        if push != 0.0:  # adding 0.0 would turn -0.0 into 0.0, and logs without it re-execute bit for bit
            volts += max(friction, 0.0) * (1.0 - abs(direction)) * clamp(push, -self._feedback_share, self._feedback_share)
        return volts

    def _at(self, temperature_C: float) -> tuple[float, float, float, float]:
        below, above, share = between(self._temperatures, temperature_C)
        a, b = self._points[below], self._points[above]
        return (
            a[0] + share * (b[0] - a[0]),
            a[1] + share * (b[1] - a[1]),
            a[2] + share * (b[2] - a[2]),
            a[3] + share * (b[3] - a[3]),
        )

    def snapshot(self) -> dict[str, Any]:
        return {"temperature_C": self.temperature_C}

    def restore(self, state: dict[str, Any]) -> None:
        self.temperature_C = state["temperature_C"]
        self._values = (0.0, 0.0, 0.0, 0.0) if self.temperature_C is None else self._at(self.temperature_C)


def _back(point: OilPoint) -> float:
    return point.velocity_factor if point.velocity_factor_back is None else point.velocity_factor_back
