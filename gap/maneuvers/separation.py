"""How well a maneuver separates two explanations when one of them is the truth and the other may refit.

The maneuver is run on the rig of one explanation; both then predict that log window by window, as a search would, each with the start
states marginalised about itself. T = ‖P r‖² − ‖P₀ r₀‖²: r is what the rival leaves of the log in noise units, and P takes out what its
start states, the rig's uncertain constants within their priors and its own parameters can do. r₀ is what the true model leaves of its
own log: windows start from a smoothed motion, so near standstill even the truth is not predicted exactly, and what is no more than
that separates nothing. A projection shared by both would not do: a late encoder starts its windows in another phase of the motion.

The rival is linearised about the truth's constants: what two fits of a constant happen to differ by, that of a bristle's stiffness most
of all, is no difference between effects.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from config.loading.load import LoadedRig
from gap.data.measured import Array, Measured
from gap.data.noise import noise_floors
from gap.data.window_length import window_length_s
from gap.data.windows import Experiment, prepare
from gap.fitting.compare import paired_t
from gap.fitting.evaluation import Evaluation, evaluate
from gap.fitting.model import Model
from gap.fitting.sensitivity import projected, sensitivities
from gap.fitting.simulate import simulate
from gap.maneuvers.earlier_logs import EarlierLogs

_LOOSE = 1e-6  # precision of a parameter without a prior


@dataclass(frozen=True, slots=True)
class Rival:
    """One explanation: its name and its model, in which everything is free that a fit would move."""

    name: str
    model: Model
    earlier: EarlierLogs | None = None

    def with_constants_of(self, other: Rival) -> Rival:
        """This explanation's effects beside the other's values of the rig file's constants."""
        known = {free.key: value for free, value in zip(other.model.free, other.model.theta, strict=True) if free.prior}
        theta = [known.get(free.key, value) if free.prior else value for free, value in zip(self.model.free, self.model.theta, strict=True)]
        return replace(self, model=self.model.with_theta(np.array(theta)))

    def seen_by(self, channels: Sequence[str]) -> Rival:
        """This explanation with the sensors that can matter to these channels: no reading of theirs depends on any other."""
        return replace(self, model=_of_sensors(self.model, channels))

    def has_constants_of(self, other: Rival) -> bool:
        return np.array_equal(self.with_constants_of(other).model.theta, self.model.theta)


@dataclass(frozen=True, slots=True)
class Separation:
    """`T` in noise units squared, 0 where the rival leaves no more than the truth; `t`: what the search would compute for the pair on
    this log, window by window."""

    T: float
    t: float

    def or_less(self, other: Separation) -> Separation:
        """What both allow."""
        return Separation(min(self.T, other.T), min(self.t, other.t))


@dataclass(frozen=True)
class RivalRun:
    """A maneuver run on the rig of one explanation, cut into windows of the `channels` looked at."""

    truth: Rival
    experiment: Experiment
    channels: tuple[str, ...]

    def apart(self, rival: Rival) -> Array:
        """Mean square distance of the two from window starts in common, in noise units, of every channel."""
        vectors = [explanation.seen_by(self.channels).model.vector() for explanation in (self.truth, rival)]
        readings = simulate(self.experiment, vectors)
        away = (readings[1] - readings[0]) / self.experiment.sigma
        return np.asarray(np.mean(np.nan_to_num(away) ** 2, axis=(0, 1)))

    @cached_property
    def own(self) -> Evaluation:
        """How well the truth predicts its own log."""
        return evaluate(self.experiment, self.truth.seen_by(self.channels).model, None)

    def beside(self, rival: Rival) -> Comparison:
        """The rival on the same log, as it is."""
        rival = rival.seen_by(self.channels)
        return Comparison(self, rival, evaluate(self.experiment, rival.model, None))

    def alike(self, rival: Rival) -> Comparison:
        """The rival on the same log, with the truth's constants; compared once."""
        if rival.name not in self._alike:
            self._alike[rival.name] = self.beside(rival.with_constants_of(self.truth))
        return self._alike[rival.name]

    @cached_property
    def _alike(self) -> dict[str, Comparison]:
        return {}


@dataclass(frozen=True, slots=True)
class Comparison:
    """A rival, with the sensors looked at, on a log of the truth: `seen` is what it leaves of it, windows × (values + start states)."""

    run: RivalRun
    rival: Rival
    seen: Evaluation

    @property
    def log(self) -> Measured:
        return self.seen.experiment.log

    def bound(self) -> Separation:
        """With the constants held and a truth that predicts its log exactly: no more than this can the maneuver separate."""
        numbers = _own(self.rival.model)
        return self._separation(self._columns(numbers), numbers, self.run.channels, None)

    def exact(self) -> Separation:
        """With everything refitted, beside what the truth itself leaves."""
        return self.each([self.run.channels])[0]

    def each(self, sets: Sequence[Sequence[str]]) -> list[Separation]:
        """With everything refitted, as if only the channels of each set were measured."""
        numbers = list(range(len(self.rival.model.free)))
        columns = self._columns(numbers)
        return [self._separation(columns, numbers, channels, self.run.own) for channels in sets]

    def step(self) -> Array:
        """How the rival's own parameters would have to move (in their scales) for it to come nearest to the truth."""
        numbers = _own(self.rival.model)
        flat = self._columns(numbers).reshape(len(numbers), self.seen.left.size)
        return np.asarray(np.linalg.lstsq(flat.T, self.seen.left.ravel(), rcond=None)[0])

    def _columns(self, numbers: Sequence[int]) -> Array:
        if not numbers:
            return np.zeros((0, *self.seen.left.shape))
        found = sensitivities(self.rival.model, [self.seen.experiment], numbers, [self.seen.readings])[0]
        return projected(self.seen, found)

    def _separation(self, columns: Array, numbers: Sequence[int], channels: Sequence[str], own: Evaluation | None) -> Separation:
        kept = self._kept(self.seen, channels)
        e, flat = (self.seen.left * kept).ravel(), (columns * kept).reshape(len(numbers), self.seen.left.size)
        shift, costs = self._moved(flat, e, numbers)
        rest = (e - shift @ flat).reshape(self.seen.left.shape)
        floor = own.left * self._kept(own, channels) if own else np.zeros_like(rest)
        T = float(np.sum(rest**2) + costs - np.sum(floor**2))
        return Separation(max(T, 0.0), self._expected_t(rest, floor, channels) if T > 0.0 else 0.0)

    def _moved(self, flat: Array, left: Array, numbers: Sequence[int]) -> tuple[Array, float]:
        """How far these numbers would move (in scales), and what that costs beside priors and earlier logs."""
        model, own = self.rival.model, list(numbers)
        precision = np.diag([1.0 if free.prior else _LOOSE for free in model.free])
        information, off = self.rival.earlier.of(model) if self.rival.earlier else (np.zeros_like(precision), np.zeros(len(precision)))
        shift = np.zeros(len(precision))
        pull = flat @ left - (information @ off)[own]
        shift[own] = np.linalg.solve(flat @ flat.T + (precision + information)[np.ix_(own, own)], pull) if own else 0.0
        return shift[own], float(shift @ precision @ shift + (off + shift) @ information @ (off + shift))

    def _kept(self, evaluation: Evaluation, channels: Sequence[str]) -> Array:
        """1 for the values of the channels that count and for the start states."""
        shape = evaluation.experiment.measured.shape
        kept = np.ones(evaluation.left.shape[1])
        kept[: shape[1] * shape[2]] = np.tile([name in channels for name in self.run.channels], shape[1])
        return kept

    def _expected_t(self, rest: Array, floor: Array, channels: Sequence[str]) -> float:
        """The search's own comparison, the noise at its expectation: it adds 1 to the cost of every window."""
        whole = self.seen.experiment
        counted = np.array([name in channels for name in self.run.channels])
        experiment = replace(whole, measured=np.where(counted, whole.measured, np.nan))
        values = np.maximum(np.isfinite(experiment.measured).sum(axis=(1, 2)), 1)
        sides = [replace(self.seen, experiment=experiment, window_costs=1.0 + np.sum(left**2, axis=1) / values) for left in (rest, floor)]
        return max(paired_t(sides[:1], sides[1:]), 0.0)


def observed(loaded: LoadedRig, truth: Rival, log: Measured, measured: Sequence[str] | None = None, workers: int = 1) -> RivalRun:
    """The truth's own log, cut into windows. `measured`: the channels looked at (default: all of the log)."""
    channels = tuple(name for name in log.channels if measured is None or name in measured)
    sigma: Mapping[str, float] = noise_floors([log], truth.model.rig)
    window_s = window_length_s(loaded.rig, [log], sigma)
    rig = truth.seen_by(channels).model.rig
    return RivalRun(truth, prepare(log, rig, sigma, window_s, channels, workers), channels)


def _of_sensors(model: Model, channels: Sequence[str]) -> Model:
    """The model with fewer sensors: the channels', those from which windows start, and those with an effect. The others' constants go."""
    plant = model.rig.plant
    assert plant is not None
    places = {entry.where.removeprefix("sensor:") for entry in plant.effects}
    starting = {f"{joint}.position" for joint in plant.joints} | {"tip.deflection"}
    seen = {*channels, *starting, *places}
    kept = {name: sensor for name, sensor in plant.sensors.items() if name in seen or name == "reservoir_temperature"}
    numbers = [k for k, free in enumerate(model.free) if free.path[0] != "sensors" or free.path[1] in seen]
    rig = model.rig.model_copy(update={"plant": plant.model_copy(update={"sensors": kept})})
    return replace(model.restricted(numbers), rig=rig)


def _own(model: Model) -> list[int]:
    return [k for k, free in enumerate(model.free) if not free.prior]
