"""Velocity from positions: derivative behind a first-order low-pass, exact at the samples for a held input."""

from __future__ import annotations

from math import exp, pi


class VelocityEstimate:
    """v̇ = ω_c (Δp/T − v). The corner is `servo.velocity_filter`."""

    __slots__ = ("_period_s", "_position", "_share", "velocity")

    def __init__(self, corner_Hz: float, period_s: float) -> None:
        self._period_s = period_s
        self._share = 1.0 - exp(-2.0 * pi * corner_Hz * period_s)
        self._position: float | None = None
        self.velocity = 0.0

    def step(self, position: float) -> float:
        """The estimate after this sample (rad/s or m/s). The first sample gives 0; positions must be finite."""
        if self._position is not None:
            self.velocity += self._share * ((position - self._position) / self._period_s - self.velocity)
        self._position = position
        return self.velocity

    def snapshot(self) -> list[float | None]:
        return [self._position, self.velocity]

    def restore(self, state: list[float | None]) -> None:
        self._position = state[0]
        self.velocity = float(state[1] or 0.0)
