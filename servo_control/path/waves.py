"""Excitation signals: w(t), ẇ(t), ẅ(t) in the unit of their amplitude (rad, m or V). All start and end at 0."""

from __future__ import annotations

from math import cos, exp, log, pi, sin
from typing import Protocol


class Wave(Protocol):
    """Defined on 0 ≤ t ≤ duration_s."""

    duration_s: float

    def at(self, t: float) -> tuple[float, float, float]: ...


class Fade:
    """Window that rises smoothly (quintic, continuous acceleration) over fade_s and falls over the last fade_s."""

    __slots__ = ("_duration_s", "_fade_s")

    def __init__(self, fade_s: float, duration_s: float) -> None:
        self._fade_s, self._duration_s = fade_s, duration_s

    def at(self, t: float) -> tuple[float, float, float]:
        """The window and its first two derivatives."""
        left = self._duration_s - t
        if t <= 0.0 or left <= 0.0:
            return 0.0, 0.0, 0.0
        if t < self._fade_s:
            return smooth_step(t, self._fade_s)
        if left < self._fade_s:
            value, rate, acceleration = smooth_step(left, self._fade_s)
            return value, -rate, acceleration
        return 1.0, 0.0, 0.0

    def times(self, t: float, w: float, w1: float, w2: float) -> tuple[float, float, float]:
        """Window × wave with product rule."""
        f, f1, f2 = self.at(t)
        return f * w, f1 * w + f * w1, f2 * w + 2.0 * f1 * w1 + f * w2


def smooth_step(t: float, length_s: float) -> tuple[float, float, float]:
    """u³(10 − 15u + 6u²), u = t/length, and two derivatives in t; 0 before 0 and 1 after length."""
    if t <= 0.0:
        return 0.0, 0.0, 0.0
    if t >= length_s:
        return 1.0, 0.0, 0.0
    u = t / length_s
    value = u * u * u * (10.0 + u * (6.0 * u - 15.0))
    rate = 30.0 * u * u * (1.0 - u) ** 2 / length_s
    return value, rate, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (length_s * length_s)


class Sweep:
    """A·sin φ(t), φ̇/2π from one frequency to another, linearly or logarithmically in time."""

    __slots__ = ("_amplitude", "_fade", "_from_Hz", "_logarithmic", "_slope", "duration_s")

    def __init__(self, amplitude: float, from_Hz: float, to_Hz: float, duration_s: float, fade_s: float, *, logarithmic: bool) -> None:
        self.duration_s = duration_s
        self._amplitude, self._from_Hz = amplitude, from_Hz
        self._logarithmic = logarithmic and from_Hz != to_Hz
        self._slope = log(to_Hz / from_Hz) / duration_s if self._logarithmic else (to_Hz - from_Hz) / duration_s
        self._fade = Fade(fade_s, duration_s)

    def at(self, t: float) -> tuple[float, float, float]:
        phase, omega, omega_rate = self._phase(t)
        s, c = sin(phase), cos(phase)
        a = self._amplitude
        return self._fade.times(t, a * s, a * omega * c, a * (omega_rate * c - omega * omega * s))

    def _phase(self, t: float) -> tuple[float, float, float]:
        start = 2.0 * pi * self._from_Hz
        if not self._logarithmic:
            return start * t + pi * self._slope * t * t, start + 2.0 * pi * self._slope * t, 2.0 * pi * self._slope
        omega = start * exp(self._slope * t)
        return (omega - start) / self._slope, omega, omega * self._slope


class Triangle:
    """0 → +A → −A → 0, repeated, with constant slope; for commands in volts."""

    __slots__ = ("_amplitude", "_period_s", "_rate", "duration_s")

    def __init__(self, amplitude: float, rate: float, cycles: int) -> None:
        self._amplitude, self._rate = amplitude, rate
        self._period_s = 4.0 * abs(amplitude) / rate
        self.duration_s = cycles * self._period_s

    def at(self, t: float) -> tuple[float, float, float]:
        if t >= self.duration_s:
            return 0.0, 0.0, 0.0
        quarter = (t % self._period_s) / self._period_s * 4.0
        if quarter < 1.0:
            return self._amplitude * quarter, self._rate, 0.0
        if quarter < 3.0:
            return self._amplitude * (2.0 - quarter), -self._rate, 0.0
        return self._amplitude * (quarter - 4.0), self._rate, 0.0


class Stairs:
    """Levels step, 2·step, …, n·step, …, step, each held; for commands in volts."""

    __slots__ = ("_hold_s", "_levels", "duration_s")

    def __init__(self, step: float, steps: int, hold_s: float) -> None:
        self._levels = [step * k for k in (*range(1, steps + 1), *range(steps - 1, -1, -1))]
        self._hold_s = hold_s
        self.duration_s = len(self._levels) * hold_s

    def at(self, t: float) -> tuple[float, float, float]:
        index = int(t / self._hold_s)
        return (self._levels[index] if index < len(self._levels) else 0.0), 0.0, 0.0
