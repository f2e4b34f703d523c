"""Convolution with fixed impulses on a history of the target: ZV, ZVD, EI, two-hump EI, three-term with fixed T.

Delays need not be multiples of the period (linear interpolation). The reference rate is the same sum over the target rate.
"""

from __future__ import annotations

from collections.abc import Sequence

from servo_control.shapers.history import History
from servo_control.shapers.impulses import Impulses
from servo_control.shapers.shaper import Snapshot


class FixedShaper:
    """The same impulses for every shaped joint; other joints pass unchanged."""

    __slots__ = ("_delays", "_history", "_joints", "flush_s")

    def __init__(self, impulses: Impulses, joints: Sequence[int], period_s: float) -> None:
        amplitudes, times = impulses
        self._delays = tuple((a, t / period_s) for a, t in zip(amplitudes, times, strict=True))
        self._joints = tuple(joints)
        self._history = History(2 * len(self._joints), int(times[-1] / period_s) + 2)
        self.flush_s = times[-1] + 2.0 * period_s

    def reset(self, target: Sequence[float]) -> None:
        self._history.reset([value for j in self._joints for value in (target[j], 0.0)])

    def step(self, target: Sequence[float], target_rate: Sequence[float], reference: list[float], reference_rate: list[float]) -> None:
        reference[:] = target
        reference_rate[:] = target_rate
        history = self._history
        history.append([value for j in self._joints for value in (target[j], target_rate[j])])
        for place, j in enumerate(self._joints):
            position, rate = history.columns[2 * place], history.columns[2 * place + 1]
            reference[j] = sum([a * history.delayed(position, d) for a, d in self._delays])
            reference_rate[j] = sum([a * history.delayed(rate, d) for a, d in self._delays])

    def snapshot(self) -> Snapshot:
        return self._history.snapshot()

    def restore(self, state: Snapshot) -> None:
        self._history.restore(state)
