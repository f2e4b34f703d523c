"""How well one maneuver separates two explanations, one of them allowed to refit.

Both models get the same commands, those of the closed loop of the first, and start every window where that run was. With d the
difference of their readings over the noise, T = ‖P d‖²: P takes out what the start states, the rig's uncertain constants within their
priors and the rival's own parameters can do. The smaller of T(first, second) and T(second, first) counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from config.load import LoadedRig
from gap.closed_loop import measured_on
from gap.compare import paired_t
from gap.evaluation import Costing, Evaluation, judged
from gap.initial_states import marginalised, start_states
from gap.measured import Array, Measured
from gap.model import Free, Model
from gap.noise import noise_floors
from gap.sensitivity import projected, sensitivities
from gap.simulate import simulate
from gap.window_length import window_length_s
from gap.windows import prepare

_LOOSE = 1e-6  # precision of a parameter without a prior


@dataclass(frozen=True, slots=True)
class Rival:
    """One explanation: its name and its model, in which everything is free that a fit would move."""

    name: str
    model: Model


@dataclass(frozen=True, slots=True)
class Separation:
    """`T` in noise units squared; `t`: what the search would compute for the pair on this log, window by window."""

    T: float
    t: float


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two rivals on one simulated log: windows × values of their difference, start states taken out."""

    rivals: tuple[Rival, Rival]
    base: tuple[Evaluation, Evaluation]
    difference: Array
    channels: tuple[str, ...]

    @property
    def log(self) -> Measured:
        return self.base[0].experiment.log

    def bound(self) -> Separation:
        """With the constants held: no more than this can the maneuver separate."""
        return self._least([self._columns(side, _own(rival.model)) for side, rival in enumerate(self.rivals)], self._kept(self.channels))

    def exact(self) -> Separation:
        """With everything refitted."""
        return self.each([self.channels])[0]

    def each(self, sets: Sequence[Sequence[str]]) -> list[Separation]:
        """With everything refitted, as if only the channels of each set were measured."""
        columns = [self._columns(side, range(len(rival.model.free))) for side, rival in enumerate(self.rivals)]
        return [self._least(columns, self._kept(channels)) for channels in sets]

    def step(self, side: int, numbers: Sequence[int]) -> Array:
        """How these numbers of one rival would have to move (in their scales) for it to come nearest to the other."""
        columns, free = self._columns(side, numbers)
        flat = columns.reshape(len(free), self.difference.size)
        towards = self.difference.ravel() if side == 1 else -self.difference.ravel()
        return np.asarray(np.linalg.lstsq(flat.T, towards, rcond=None)[0])

    def _columns(self, side: int, numbers: Sequence[int]) -> tuple[Array, list[Free]]:
        base, model = self.base[side], self.rivals[side].model
        free = [model.free[k] for k in numbers]
        if not free:
            return np.zeros((0, *self.difference.shape)), free
        return projected(base, sensitivities(model, [base.experiment], numbers, [base.readings])[0]), free

    def _kept(self, channels: Sequence[str]) -> Array:
        """1 for the values of the channels that count and for the start states."""
        shape = self.base[0].experiment.measured.shape
        kept = np.ones(self.difference.shape[1])
        kept[: shape[1] * shape[2]] = np.tile([name in channels for name in self.channels], shape[1])
        return kept

    def _least(self, columns: Sequence[tuple[Array, list[Free]]], kept: Array) -> Separation:
        found = [self._separation(c * kept, free, self.difference * kept) for c, free in columns]
        return min(found, key=lambda item: item.T)

    def _separation(self, columns: Array, free: list[Free], difference: Array) -> Separation:
        flat, e = columns.reshape(len(free), difference.size), difference.ravel()
        precision = np.diag([1.0 if item.prior else _LOOSE for item in free])
        shift = np.linalg.solve(flat @ flat.T + precision, flat @ e) if free else np.zeros(0)
        rest = e - shift @ flat
        T = float(rest @ rest + shift @ precision @ shift)
        return Separation(T, self._expected_t(rest.reshape(difference.shape)))

    def _expected_t(self, rest: Array) -> float:
        """The search's own comparison, the noise at its expectation: costs 1 with the truth, more with the rival."""
        experiment = self.base[0].experiment
        values = experiment.measured.shape[1] * experiment.measured.shape[2]
        right = replace(self.base[0], window_costs=np.ones(experiment.windows))
        wrong = replace(self.base[0], window_costs=1.0 + (rest**2).sum(axis=1) / values)
        return max(paired_t([wrong], [right]), 0.0)


def compare(
    loaded: LoadedRig, first: Rival, second: Rival, maneuver: dict[str, Any], measured: Sequence[str] | None = None, workers: int = 1
) -> Comparison:
    """Run the maneuver on the first rival's rig and compare on its log. ManeuverError when that run would not be safe.

    `measured`: the channels that will be logged (default: all the plant has sensors for).
    """
    log = measured_on(first.model.fitted_rig(), maneuver)
    channels = [name for name in log.channels if measured is None or name in measured]
    sigma = noise_floors([log], first.model.rig)
    experiment = prepare(log, first.model.rig, sigma, window_length_s(loaded.rig, [log], sigma), channels, workers)
    vectors = [rival.model.vector() for rival in (first, second)]
    freer = max(vectors, key=lambda p: len(start_states(p, experiment)))
    projection = marginalised(experiment, freer)
    plain = Costing(np.full(len(channels), np.inf), 1.0)
    base = [judged(experiment, readings, projection, plain) for readings in simulate(experiment, vectors)]
    apart = (base[0].readings - base[1].readings) / experiment.sigma
    difference = projection.apply(np.nan_to_num(apart).reshape(experiment.windows, -1))
    return Comparison((first, second), (base[0], base[1]), difference, tuple(channels))


def _own(model: Model) -> list[int]:
    return [k for k, free in enumerate(model.free) if not free.prior]
