"""Notch (s² + 2ζ_nω s + ω²)/(s² + 2ζ_dω s + ω²), Tustin, and the robust notch: two of them in cascade at 0.9 ω and 1.11 ω.

The filter works on the difference to the start, in transposed direct form II; it is linear, so the reference rate is the same
filter over the target rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log

from servo_control.shapers.shaper import Snapshot

POLE_DAMPING = 0.7
ROBUST_SPREAD = (0.9, 1.11)
SETTLED_SHARE = 1e-6  # what may be left of a step when the filter counts as flushed

Biquad = tuple[float, float, float, float, float]


def notch_coefficients(omega: float, zero_damping: float, pole_damping: float, period_s: float) -> Biquad:
    """(b0, b1, b2, a1, a2) by the Tustin rule, a0 = 1."""
    c = 2.0 / period_s
    centre, edge = 2.0 * (omega * omega - c * c), c * c + omega * omega
    norm = edge + 2.0 * pole_damping * omega * c
    middle = 2.0 * zero_damping * omega * c
    return (
        (edge + middle) / norm,
        centre / norm,
        (edge - middle) / norm,
        centre / norm,
        (edge - 2.0 * pole_damping * omega * c) / norm,
    )


class NotchShaper:
    """Notches in cascade on the shaped joints."""

    __slots__ = ("_biquads", "_joints", "_start", "_states", "flush_s")

    def __init__(self, centres_rad_per_s: Sequence[float], zero_damping: float, joints: Sequence[int], period_s: float) -> None:
        self._biquads = tuple(notch_coefficients(w, zero_damping, POLE_DAMPING, period_s) for w in centres_rad_per_s)
        self._joints = tuple(joints)
        self._start: list[float] = []
        self._states: list[list[float]] = []
        self.flush_s = log(1.0 / SETTLED_SHARE) / (POLE_DAMPING * min(centres_rad_per_s)) + len(self._biquads) * period_s

    def reset(self, target: Sequence[float]) -> None:
        self._start = list(target)
        self._states = [[0.0] * (2 * len(self._biquads)) for _ in range(2 * len(self._joints))]

    def step(self, target: Sequence[float], target_rate: Sequence[float], reference: list[float], reference_rate: list[float]) -> None:
        reference[:] = target
        reference_rate[:] = target_rate
        for place, j in enumerate(self._joints):
            start = self._start[j]
            reference[j] = start + self._filter(target[j] - start, self._states[2 * place])
            reference_rate[j] = self._filter(target_rate[j], self._states[2 * place + 1])

    def _filter(self, x: float, states: list[float]) -> float:
        for i, (b0, b1, b2, a1, a2) in enumerate(self._biquads):
            y = b0 * x + states[2 * i]
            states[2 * i] = b1 * x - a1 * y + states[2 * i + 1]
            states[2 * i + 1] = b2 * x - a2 * y
            x = y
        return x

    def snapshot(self) -> Snapshot:
        return {"start": list(self._start), "states": [list(states) for states in self._states]}

    def restore(self, state: Snapshot) -> None:
        self._start = list(state["start"])
        self._states = [list(states) for states in state["states"]]
