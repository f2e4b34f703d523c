"""Which maneuver would tell two explanations apart soonest: T-optimal over the shipped maneuvers and their forms within the envelope.

A best-first search: a maneuver that has not been simulated needs at least its own duration, one simulated with the constants held at
least as long as that bound says; the maneuver whose exact time comes out of the queue first is the soonest of all. Where none
separates, every sensor the rig does not have is tried on the most telling maneuvers.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count, islice
from typing import Any

import numpy as np

from config.errors import ConfigError, LongreachError
from config.load import LoadedRig
from gap.candidates import candidates
from gap.closed_loop import measured_on, planned
from gap.designs import Design, designs
from gap.extra_sensor import extra_sensors, with_sensors
from gap.model import Model
from gap.nuisance import nuisances
from gap.separation import Comparison, Rival, Separation, compare
from gap.settings import PROCESSORS

LEAST_T = 9.0  # below this the two are the same to the maneuver, whatever is fitted
WANTED_T = 5.0
MOST_REPEATS = 10
SENSOR_TRIALS = 2  # maneuvers on which sensors are tried
NONE = "no missing effect"

Tell = Callable[[str], None]
_Entry = tuple[float, float, Design, Comparison, "Proposal | None"]  # least time until t > 5, -t, and what they belong to


@dataclass(frozen=True, slots=True)
class Proposal:
    """One maneuver and how well it would separate the two; `sensor`: only with these channels fitted."""

    design: Design
    separates: tuple[str, str]
    separation: Separation
    duration_s: float
    sensor: tuple[str, ...] = ()

    @property
    def repeats(self) -> int | None:
        """Runs needed for t > 5; None when that is too many."""
        return _repeats(self.separation)

    @property
    def time_s(self) -> float:
        """Until t > 5."""
        return self.duration_s * self.repeats if self.repeats else np.inf

    @property
    def why(self) -> str:
        if self.repeats is None:
            return f"no maneuver and no other sensor separates the two (t {self.separation.t:.1f} at best); change the payload or the oil"
        runs = "one run" if self.repeats == 1 else f"needs {self.repeats} repeats for t > {WANTED_T:g}"
        expected = f"expected t {self.separation.t:.1f} in {self.duration_s:.0f} s, {runs}"
        return f"only another sensor separates the two: with {' and '.join(self.sensor)} {expected}" if self.sensor else expected

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.design.name,
            "parameters": dict(self.design.parameters),
            "why": self.why,
            "expected_t": round(self.separation.t, 2),
            "T": round(self.separation.T, 2),
            "separates": list(self.separates),
            "duration_s": round(self.duration_s, 2),
            "repeats": self.repeats,
            "sensor": list(self.sensor) or None,
        }


def next_maneuver(
    loaded: LoadedRig, first: Rival, second: Rival, tell: Tell, measured: Sequence[str] | None = None, thorough: bool = True
) -> Proposal | None:
    """The maneuver that separates the two soonest, else a sensor that would; None when the rig allows no maneuver at all.

    `measured`: channels the rig logs (default: all its plant has sensors for). Forms are made for the joints concerned; with `thorough`
    every shipped maneuver takes part as it is.
    """
    assert loaded.rig.plant is not None
    course = _Course(loaded, (first, second), tuple(measured or loaded.rig.plant.sensors), tell)
    found = course.soonest(designs(loaded.rig, _concerned(loaded, (first, second)), thorough))
    if found is not None or not course.seen:
        return found
    tell("no maneuver separates the two with the sensors fitted; trying others")
    return course.best_sensor()


def rival_of(
    loaded: LoadedRig,
    effect: str,
    where: str,
    parameters: Mapping[str, float] | None = None,
    constants: Mapping[str, float] | None = None,
) -> Rival:
    """The rig with one effect at given parameters, or at its typical size. ConfigError when the rig has no place for it.

    `constants`: refitted values of the rig file's constants, by their key.
    """
    base = no_effect(loaded, constants).model
    assert loaded.rig.plant is not None
    possible = candidates(loaded.rig, frozenset(loaded.rig.plant.sensors))
    chosen = next((c for c in possible if (c.effect, c.where) == (effect, where)), None)
    if chosen is None:
        advice = f"Possible: {', '.join(sorted({c.label for c in possible}))}."
        raise ConfigError("this effect cannot be added to the rig", value=f"{effect} at {where}", where=loaded.path, next_step=advice)
    model = base.with_effect(chosen.entry, chosen.free)
    values = [(parameters or {}).get(free.key, start) for free, start in zip(chosen.free, chosen.starts[0], strict=True)]
    return Rival(chosen.label, model.with_theta(np.concatenate([base.theta, values])))


def no_effect(loaded: LoadedRig, constants: Mapping[str, float] | None = None) -> Rival:
    """The rig file without a further effect, its constants free."""
    assert loaded.rig.plant is not None
    free = nuisances(loaded, frozenset(loaded.rig.plant.sensors))
    return Rival(NONE, Model(loaded.rig, free, np.array([(constants or {}).get(item.key, item.start) for item in free])))


def _concerned(loaded: LoadedRig, rivals: Sequence[Rival]) -> list[str]:
    """The joints at which the two differ; all of them when it is not a joint."""
    joints = list(loaded.rig.joints)
    places = [rival.model.added[-1].where for rival in rivals if rival.model.added]
    named = [joint for joint in joints if any(place.removeprefix("sensor:").split(".")[0] == joint for place in places)]
    return named or joints


def _repeats(separation: Separation) -> int | None:
    if separation.T < LEAST_T or separation.t <= 0.0:
        return None
    needed = int(np.ceil((WANTED_T / separation.t) ** 2))
    return needed if needed <= MOST_REPEATS else None


@dataclass(slots=True)
class _Course:
    """One search: what was simulated, and the queue's steps."""

    loaded: LoadedRig
    rivals: tuple[Rival, Rival]
    measured: tuple[str, ...]
    tell: Tell
    seen: list[tuple[Separation, Design]] = field(default_factory=list)

    @property
    def names(self) -> tuple[str, str]:
        return self.rivals[0].name, self.rivals[1].name

    def soonest(self, wanted: Sequence[Design]) -> Proposal | None:
        order = count()
        queue: list[tuple[float, float, int, Design, Comparison | None, Proposal | None]] = []
        for design in wanted:
            duration = self._duration(design)
            if duration is not None:
                heapq.heappush(queue, (duration, -np.inf, next(order), design, None, None))
        while queue:
            least_s, _, _, design, comparison, proposal = heapq.heappop(queue)
            if not np.isfinite(least_s):
                return None
            if proposal is not None:
                return proposal
            entry = self._bounded(design) if comparison is None else self._exact(design, comparison)
            if entry is not None:
                heapq.heappush(queue, (*entry[:2], next(order), *entry[2:]))
        return None

    def _duration(self, design: Design) -> float | None:
        try:
            return planned(self.rivals[0].model.fitted_rig(), design.content).duration_s
        except LongreachError as refused:
            self.tell(f"  {design.label}: not on this rig ({refused.refusal.what})")
            return None

    def _bounded(self, design: Design) -> _Entry | None:
        if any(design == other for _, other in self.seen):
            return None
        try:
            comparison = compare(self.loaded, *self.rivals, design.content, self.measured, PROCESSORS)
        except LongreachError as refused:
            self.tell(f"  {design.label}: not on this rig ({refused.refusal.what})")
            return self._bounded(design.smaller) if design.smaller else None
        bound = comparison.bound()
        self.seen.append((bound, design))
        self.tell(f"  {design.label}: expected t at most {bound.t:.1f} in {comparison.log.duration_s:.0f} s")
        return Proposal(design, self.names, bound, comparison.log.duration_s).time_s, -bound.t, design, comparison, None

    def _exact(self, design: Design, comparison: Comparison) -> _Entry | None:
        if not self._safe(design):
            return self._bounded(design.smaller) if design.smaller else None
        separation = comparison.exact()
        self.tell(f"  {design.label}: expected t {separation.t:.1f} with all constants refitted")
        proposal = Proposal(design, self.names, separation, comparison.log.duration_s)
        return proposal.time_s, -separation.t, design, comparison, proposal

    def _safe(self, design: Design) -> bool:
        """Whether the second rival's rig could run it too: either may be the truth. The first has run it already."""
        try:
            measured_on(self.rivals[1].model.fitted_rig(), design.content)
        except LongreachError as refused:
            self.tell(f"  {design.label}: not if {self.rivals[1].name} is the truth ({refused.refusal.what})")
            return False
        return True

    def best_sensor(self) -> Proposal:
        """Sensors the rig does not have, on the maneuvers whose bound was highest."""
        order = sorted(self.seen, key=lambda item: -item[0].T)
        telling = list(islice((item for item in order if self._safe(item[1])), SENSOR_TRIALS)) or order[:1]
        extras = extra_sensors(self.loaded.rig, self.measured)
        every = (*self.measured, *(channel for extra in extras for channel in extra.channels))
        rivals = [replace(rival, model=with_sensors(rival.model, extras)) for rival in self.rivals]
        found = []
        for bound, design in telling:
            comparison = compare(self.loaded, rivals[0], rivals[1], design.content, every, PROCESSORS)
            found.append(Proposal(design, self.names, bound, comparison.log.duration_s))
            for extra, separation in zip(extras, comparison.each([(*self.measured, *extra.channels) for extra in extras]), strict=True):
                self.tell(f"  {design.label} with {' and '.join(extra.channels)}: expected t {separation.t:.1f}")
                found.append(Proposal(design, self.names, separation, comparison.log.duration_s, extra.channels))
        return min(found, key=lambda p: (p.time_s, -p.separation.T))
