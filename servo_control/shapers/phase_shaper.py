"""Adaptive three-term filter in the phase domain: every input increment is given out after half and one whole cycle of the
oscillator as it really is, while its frequency follows the extension, (S3) of docs/method/shaping.md.

    φ(t) = ∫ ω_d(L) dt,    y(t) = Σ A_i u(s_i),  φ(t) − φ(s_i) = i π,    ẏ(t) = Σ A_i u̇(s_i) ω_d(t)/ω_d(s_i)

With two amplitudes instead of three only after half a cycle: later by half as much, and less forgiving.

The frequency is scheduled on the target extension, or, when the extension itself is shaped, on the extension it gave out in
the cycle before: the unshaped one would be half a cycle early.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from servo_control.link.link_mode import LinkFrequency
from servo_control.numerics.limits import clamp
from servo_control.shapers.history import History
from servo_control.shapers.shaper import Snapshot


class PhaseShaper:
    """`amplitudes` (sum 1): given out at once, after half a cycle and so on. `extension` is the index of the joint that sets the frequency,
    `travel` its range: the longest delay lies at its end."""

    __slots__ = (
        "_amplitudes", "_cursors", "_extension", "_extension_reference", "_history", "_joints",
        "_link", "_omega", "_period_s", "_phase", "_start", "_travel", "flush_s",
    )  # fmt: skip

    def __init__(
        self,
        link: LinkFrequency,
        amplitudes: Sequence[float],
        joints: Sequence[int],
        extension: int,
        travel: tuple[float, float],
        period_s: float,
    ) -> None:
        self._link, self._joints, self._extension, self._travel = link, tuple(joints), extension, travel
        self._period_s = period_s
        self._amplitudes = tuple(amplitudes)
        self.flush_s = (len(self._amplitudes) - 1) * pi / link.omega_d(travel[1]) + 3.0 * period_s
        self._history = History(2 + 2 * len(self._joints), int(self.flush_s / period_s) + 2)
        self._start: list[float] = []
        self._cursors = [0] * (len(self._amplitudes) - 1)
        self._phase = self._omega = self._extension_reference = 0.0

    def reset(self, target: Sequence[float]) -> None:
        self._start = list(target)
        self._extension_reference = target[self._extension]
        self._omega = self._frequency(target)
        self._phase = -self._omega * self._period_s  # so that the first sample has phase 0
        self._history.reset([0.0] * (2 + 2 * len(self._joints)))
        self._cursors = [0] * (len(self._amplitudes) - 1)

    def step(self, target: Sequence[float], target_rate: Sequence[float], reference: list[float], reference_rate: list[float]) -> None:
        reference[:] = target
        reference_rate[:] = target_rate
        omega = self._frequency(target)
        self._phase += 0.5 * (self._omega + omega) * self._period_s
        self._omega = omega
        history = self._history
        history.append([self._phase, omega, *[v for j in self._joints for v in (target[j], target_rate[j])]])
        for j in self._joints:
            reference[j] *= self._amplitudes[0]
            reference_rate[j] *= self._amplitudes[0]
        for i in range(len(self._cursors)):
            self._add_delayed(i, reference, reference_rate)
        self._extension_reference = reference[self._extension]

    def _frequency(self, target: Sequence[float]) -> float:
        extension = self._extension_reference if self._extension in self._joints else target[self._extension]
        return self._link.omega_d(clamp(extension, *self._travel))

    def _add_delayed(self, i: int, reference: list[float], reference_rate: list[float]) -> None:
        amplitude = self._amplitudes[i + 1]
        wanted = self._phase - (i + 1) * pi
        phases, mask = self._history.columns[0], self._history.mask
        if wanted < 0.0:  # before the run: at rest at the start
            for j in self._joints:
                reference[j] += amplitude * self._start[j]
            return
        cursor = self._cursors[i]
        while phases[(cursor + 1) & mask] <= wanted:
            cursor += 1
        self._cursors[i] = cursor
        early, late = cursor & mask, (cursor + 1) & mask
        share = (wanted - phases[early]) / (phases[late] - phases[early])
        omegas = self._history.columns[1]
        stretch = amplitude * self._omega / (omegas[early] + share * (omegas[late] - omegas[early]))
        for place, j in enumerate(self._joints):
            u, v = self._history.columns[2 + 2 * place], self._history.columns[3 + 2 * place]
            reference[j] += amplitude * (u[early] + share * (u[late] - u[early]))
            reference_rate[j] += stretch * (v[early] + share * (v[late] - v[early]))

    def snapshot(self) -> Snapshot:
        return {
            "history": self._history.snapshot(),
            "start": list(self._start),
            "cursors": list(self._cursors),
            "phase": self._phase,
            "omega": self._omega,
            "extension_reference": self._extension_reference,
        }

    def restore(self, state: Snapshot) -> None:
        self._history.restore(state["history"])
        self._start = list(state["start"])
        self._cursors = list(state["cursors"])
        self._phase, self._omega = state["phase"], state["omega"]
        self._extension_reference = state["extension_reference"]
