"""Which maneuver would tell explanations apart soonest: T-optimal (A. Atkinson and V. Fedorov, Biometrika 62,
1975) over the shipped maneuvers and their forms within the envelope.

Of more than two the slowest pair counts; a maneuver that leaves fewer pairs open goes before a quicker one. A best-first search: a
maneuver that has not been simulated needs at least its own duration, one simulated with the constants held at least as long as that
bound says, and every refit with another explanation as the truth can only make it longer; the maneuver that comes out of the queue with
nothing left to refit is the soonest of all. Where none separates any pair, every sensor the rig does not have is tried on the most
telling maneuvers.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, count, islice

import numpy as np

from config.errors import LongreachError
from config.loading.load import LoadedRig
from config.progress import Progress
from gap.data.measured import Measured
from gap.maneuvers.closed_loop import measured_on, planned
from gap.maneuvers.designs import ManeuverDesign, designs
from gap.maneuvers.extra_sensor import ExtraSensor, extra_sensors, with_sensors
from gap.maneuvers.proposal import Pair, Proposal
from gap.maneuvers.separation import Comparison, Rival, RivalRun, Separation, observed
from gap.settings import PROCESSORS
from servo_control.planning.run_plan import RunPlan

SENSOR_TRIALS = 2  # maneuvers on which sensors are tried
HELD_RUNS = 4  # kept with what was compared on them, for the refits of the same maneuver
_WAYS = ((False, True), (True, True))  # round a pair: whether its second is the truth; whether the rival has the truth's constants
_OWN = (False, False)


def next_maneuver(
    loaded: LoadedRig, rivals: Sequence[Rival], progress: Progress, measured: Sequence[str] | None = None, thorough: bool = True
) -> Proposal | None:
    """The maneuver that separates the explanations soonest, else a sensor that would; None when the rig allows no maneuver at all.

    `measured`: channels the rig logs (default: all its plant has sensors for). Forms are made for the joints concerned; with `thorough`
    every shipped maneuver takes part as it is.
    """
    assert loaded.rig.plant is not None
    channels = tuple(measured or loaded.rig.plant.sensors)
    extras = extra_sensors(loaded.rig, channels)
    course = _Course(loaded, [replace(rival, model=with_sensors(rival.model, extras)) for rival in rivals], channels, extras, progress)
    found = course.soonest(designs(loaded.rig, _concerned(loaded, rivals), thorough))
    if found is None or found.repeats:
        return found
    progress("no maneuver separates any of them with the sensors fitted; trying others")
    return course.best_sensor(found)


def _concerned(loaded: LoadedRig, rivals: Sequence[Rival]) -> list[str]:
    """The joints at which they differ; all of them when it is not a joint."""
    joints = list(loaded.rig.joints)
    places = [rival.model.added[-1].where for rival in rivals if rival.model.added]
    named = [joint for joint in joints if any(place.removeprefix("sensor:").split(".")[0] == joint for place in places)]
    return named or joints


@dataclass(frozen=True, slots=True)
class _Known:
    """What is known of one maneuver: at most `found` of every pair; `ways`: in which it is still to be refitted."""

    proposal: Proposal
    found: Mapping[tuple[int, int], Separation]
    ways: tuple[tuple[bool, bool], ...]

    @property
    def settled(self) -> bool:
        """Whether nothing that is still to be computed could change its place."""
        return not (self.ways and self.proposal.repeats)


@dataclass(slots=True)
class _Course:
    """One search: the explanations (with every sensor the rig could have), what was simulated, and the queue's steps."""

    loaded: LoadedRig
    rivals: Sequence[Rival]
    measured: tuple[str, ...]
    extras: Sequence[ExtraSensor]
    progress: Progress
    plans: dict[str, RunPlan] = field(default_factory=dict)
    logs: dict[tuple[str, int], Measured] = field(default_factory=dict)
    runs: dict[tuple[str, int, tuple[str, ...]], RivalRun] = field(default_factory=dict)
    seen: list[Proposal] = field(default_factory=list)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        return list(combinations(range(len(self.rivals)), 2))

    def soonest(self, wanted: Sequence[ManeuverDesign]) -> Proposal | None:
        """The best proposal, which may separate nothing; None when none of the maneuvers can be run."""
        order, queue = count(), list[tuple[tuple[int, float, float], int, ManeuverDesign | _Known]]()
        for design in wanted:
            duration = self._duration(design)
            if duration is not None:
                heapq.heappush(queue, ((0, duration, -np.inf), next(order), design))
        while queue:
            _, _, item = heapq.heappop(queue)
            if isinstance(item, _Known) and item.settled:
                return item.proposal
            known = self._refitted(item) if isinstance(item, _Known) else self._bounded(item)
            if known is not None:
                heapq.heappush(queue, (known.proposal.rank, next(order), known))
        return None

    def _duration(self, design: ManeuverDesign) -> float | None:
        try:
            self.plans[design.label] = planned(self.rivals[0].model.fitted_rig(), design.content)
            return self.plans[design.label].duration_s
        except LongreachError as refused:
            self.progress(f"  {design.label}: not on this rig ({refused.refusal.what})")
            return None

    def _log(self, design: ManeuverDesign, truth: int) -> Measured:
        """What this explanation's rig would log. ManeuverError when that run would not be safe."""
        key = (design.label, truth)
        if key not in self.logs:
            plan = self.plans.get(design.label) if truth == 0 else None  # any other may settle elsewhere
            self.logs[key] = measured_on(self.rivals[truth].model.fitted_rig(), design.content, plan)
        return self.logs[key]

    def _bounded(self, design: ManeuverDesign) -> _Known | None:
        """Every pair with the constants held, the first of it as the truth."""
        if any(design == other.design for other in self.seen):
            return None
        try:
            found = {pair: comparison.bound() for pair, comparison in self._comparisons(design, self.pairs, self.measured)}
        except LongreachError as refused:
            self.progress(f"  {design.label}: not on this rig ({refused.refusal.what})")
            return self._bounded(design.smaller) if design.smaller else None
        proposal = self._proposal(design, found)
        self.seen.append(proposal)
        self.progress(f"  {design.label}: expected t at most {proposal.least.t:.1f} in {proposal.duration_s:.0f} s")
        return _Known(proposal, found, self._ways)

    @property
    def _ways(self) -> tuple[tuple[bool, bool], ...]:
        """Either of a pair as the truth; then from the rival's own fit, where that has other constants."""
        same = all(self.rivals[b].has_constants_of(self.rivals[a]) for a, b in self.pairs)
        return _WAYS if same else (*_WAYS, _OWN)

    def _refitted(self, known: _Known) -> _Known | None:
        """The next way round every pair for which there is hope, with everything refitted."""
        design, (turned, alike) = known.proposal.design, known.ways[0]
        if known.ways == self._ways and not self._safe(design):
            return self._bounded(design.smaller) if design.smaller else None
        open_ = [pair for pair, told in zip(self.pairs, known.proposal.pairs, strict=True) if told.repeats]
        ways = [(b, a) if turned else (a, b) for a, b in open_ if alike or not self.rivals[b].has_constants_of(self.rivals[a])]
        found = dict(known.found)
        for (truth, rival), comparison in self._comparisons(design, ways, self.measured, alike):
            pair = (min(truth, rival), max(truth, rival))
            found[pair] = found[pair].or_less(comparison.exact())
        further = _Known(self._proposal(design, found), found, known.ways[1:])
        most = "" if further.settled else "at most "
        self.progress(f"  {design.label}: expected t {most}{further.proposal.least.t:.1f} with all constants refitted")
        return further

    def _safe(self, design: ManeuverDesign) -> bool:
        """Whether the rigs of all explanations could run it: any of them may be the truth."""
        for number, rival in enumerate(self.rivals):
            try:
                self._log(design, number)
            except LongreachError as refused:
                self.progress(f"  {design.label}: not if {rival.name} is the truth ({refused.refusal.what})")
                return False
        return True

    def _comparisons(
        self, design: ManeuverDesign, pairs: Sequence[tuple[int, int]], channels: tuple[str, ...], alike: bool = True
    ) -> Iterator[tuple[tuple[int, int], Comparison]]:
        """(truth, rival) in turn, with the truth's constants or (not `alike`) with the rival's own; the truth's floor is computed once."""
        for truth in sorted({pair[0] for pair in pairs}):
            run = self._run(design, truth, channels)
            beside = run.alike if alike else run.beside
            yield from ((pair, beside(self.rivals[pair[1]])) for pair in pairs if pair[0] == truth)

    def _run(self, design: ManeuverDesign, truth: int, channels: tuple[str, ...]) -> RivalRun:
        """The last few are kept: the maneuver that is refitted is mostly one of them."""
        key = (design.label, truth, channels)
        run = self.runs.pop(key, None) or observed(self.loaded, self.rivals[truth], self._log(design, truth), channels, PROCESSORS)
        self.runs = dict([*self.runs.items(), (key, run)][-HELD_RUNS:])
        return run

    def _proposal(self, design: ManeuverDesign, found: Mapping[tuple[int, int], Separation], sensor: ExtraSensor | None = None) -> Proposal:
        pairs = tuple(Pair((self.rivals[a].name, self.rivals[b].name), found[a, b]) for a, b in self.pairs)
        return Proposal(design, pairs, self._log(design, 0).duration_s, sensor)

    def best_sensor(self, without: Proposal) -> Proposal:
        """Sensors the rig does not have, on the maneuvers on which they would show the explanations furthest apart; `without` any if none
        tells."""
        order = sorted(self.seen, key=lambda item: -self._apart(item.design))
        telling = list(islice((item for item in order if self._safe(item.design)), SENSOR_TRIALS)) or order[:1]
        found = [without]
        for bound in telling:
            told: list[dict[tuple[int, int], Separation]] = [{} for _ in self.extras]
            for pair, comparison in self._comparisons(bound.design, self.pairs, self._every):
                for known, separation in zip(told, comparison.each([(*self.measured, *e.channels) for e in self.extras]), strict=True):
                    known[pair] = separation
            for extra, separations in zip(self.extras, told, strict=True):
                proposal = self._proposal(bound.design, separations, extra)
                self.progress(f"  {bound.design.label} with {extra.text}: expected t {proposal.least.t:.1f}")
                found += [proposal] if proposal.repeats else []
        return min(found, key=lambda proposal: proposal.rank)

    @property
    def _every(self) -> tuple[str, ...]:
        """All channels, with those of sensors the rig does not have."""
        return (*self.measured, *(channel for extra in self.extras for channel in extra.channels))

    def _apart(self, design: ManeuverDesign) -> float:
        """How far apart sensors the rig does not have would show the nearest pair, before anything is refitted."""
        if not self.extras:
            return 0.0
        return min(float(np.max(self._run(design, a, self._every).apart(self.rivals[b]))) for a, b in self.pairs)
