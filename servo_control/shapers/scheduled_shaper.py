"""The two simpler adaptive three-term filters, (S2) of docs/method/shaping.md, for comparison with the phase domain: frequency from the
extension,

    coefficients: fixed T, weights c(ω_d(L(t))) every cycle         delay: T(t) = π/ω_d(L(t)), ZVD weights

Their reference rates carry the terms of the changing weights (Σ ċ_i u(t − iT)) and delay (1 − iṪ), by backward difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from servo_control.link.link_mode import LinkFrequency
from servo_control.numerics.limits import clamp
from servo_control.shapers.history import History
from servo_control.shapers.impulses import three_term_amplitudes, zvd
from servo_control.shapers.shaper import Snapshot


class ScheduledShaper:
    """`delay_s` fixes T and schedules the weights; without it the delay is scheduled. Other arguments as for PhaseShaper."""

    __slots__ = (
        "_amplitudes", "_delay_s", "_extension", "_extension_reference", "_history", "_joints",
        "_last", "_link", "_period_s", "_travel", "flush_s",
    )  # fmt: skip

    def __init__(
        self,
        link: LinkFrequency,
        joints: Sequence[int],
        extension: int,
        travel: tuple[float, float],
        period_s: float,
        delay_s: float | None,
    ) -> None:
        self._link, self._joints, self._extension, self._travel = link, tuple(joints), extension, travel
        self._period_s, self._delay_s = period_s, delay_s
        self._amplitudes = zvd(1.0, link.damping_ratio)[0]
        longest = delay_s if delay_s is not None else pi / link.omega_d(travel[1])
        self.flush_s = 2.0 * longest + 3.0 * period_s
        self._history = History(2 * len(self._joints), int(self.flush_s / period_s) + 2)
        self._extension_reference = 0.0
        self._last: tuple[float, ...] = ()

    def reset(self, target: Sequence[float]) -> None:
        self._history.reset([value for j in self._joints for value in (target[j], 0.0)])
        self._extension_reference = target[self._extension]
        self._last = self._scheduled(target)

    def step(self, target: Sequence[float], target_rate: Sequence[float], reference: list[float], reference_rate: list[float]) -> None:
        reference[:] = target
        reference_rate[:] = target_rate
        self._history.append([value for j in self._joints for value in (target[j], target_rate[j])])
        scheduled = self._scheduled(target)
        slopes = [(now - before) / self._period_s for now, before in zip(scheduled, self._last, strict=True)]
        self._last = scheduled
        for place, j in enumerate(self._joints):
            columns = self._history.columns[2 * place], self._history.columns[2 * place + 1]
            if self._delay_s is None:
                reference[j], reference_rate[j] = self._with_delay(scheduled[0], slopes[0], *columns)
            else:
                reference[j], reference_rate[j] = self._with_weights(self._delay_s, scheduled, slopes, *columns)
        self._extension_reference = reference[self._extension]

    def _scheduled(self, target: Sequence[float]) -> tuple[float, ...]:
        """The delay T, or the three weights for the fixed delay, at the extension of this cycle."""
        extension = self._extension_reference if self._extension in self._joints else target[self._extension]
        omega = self._link.omega_d(clamp(extension, *self._travel))
        if self._delay_s is None:
            return (pi / omega,)
        return three_term_amplitudes(omega, self._link.damping_ratio, self._delay_s)

    def _with_delay(self, delay_s: float, slope: float, position: list[float], rate: list[float]) -> tuple[float, float]:
        y = v = 0.0
        for i, amplitude in enumerate(self._amplitudes):
            samples = i * delay_s / self._period_s
            y += amplitude * self._history.delayed(position, samples)
            v += amplitude * (1.0 - i * slope) * self._history.delayed(rate, samples)
        return y, v

    def _with_weights(
        self, delay_s: float, weights: Sequence[float], slopes: Sequence[float], position: list[float], rate: list[float]
    ) -> tuple[float, float]:
        y = v = 0.0
        for i, (weight, slope) in enumerate(zip(weights, slopes, strict=True)):
            samples = i * delay_s / self._period_s
            late = self._history.delayed(position, samples)
            y += weight * late
            v += weight * self._history.delayed(rate, samples) + slope * late
        return y, v

    def snapshot(self) -> Snapshot:
        return {"history": self._history.snapshot(), "extension_reference": self._extension_reference, "last": list(self._last)}

    def restore(self, state: Snapshot) -> None:
        self._history.restore(state["history"])
        self._extension_reference = state["extension_reference"]
        self._last = tuple(state["last"])
