"""What a search by evidence knows at one moment. Nothing in it changes: a stage takes a Search and returns another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from config.schema.rig import Rig
from gap.evidence.lines import StraightFit
from gap.evidence.score.bootstrap import Weight, bootstrapped
from gap.evidence.score.changed import changeable
from gap.evidence.score.hypothesis import Hypothesis, Seen, Suspect
from gap.evidence.score.shares import Shares, of_weights
from gap.evidence.screening import Promise
from gap.suspects.candidates import candidates

Start = tuple[frozenset[str], float]  # a set, and its `level` in Open


@dataclass(frozen=True, slots=True)
class Open:
    """A set that is not fitted from one of its starts: `lines`, `base` and one more as straight lines tell. None where they were not
    followed: then the promise beside the old discrepancy stands for them. `alone`: ln Z of the start without the suspect, beside the
    promise and along the lines; `level`: to which a descent leads without it, from the start or from where lines lead. Only what is more is
    the suspect's."""

    base: Hypothesis
    promise: Promise
    lines: StraightFit | None
    alone: tuple[float, float]
    level: float

    @property
    def labels(self) -> frozenset[str]:
        return self.base.labels | {self.promise.suspect.label}

    @property
    def start(self) -> Start:
        """From where it is promised."""
        return self.base.labels, self.level

    @property
    def gain(self) -> float:
        """What ln Z of the set is promised to be above that of the base. Where lines end below what a descent reaches without the suspect,
        what they gain with it makes up for that first, as constants would."""
        promised = self.promise.log_z - self.alone[0]
        return max(promised, self.lines.log_z - max(self.alone[1], self.level)) if self.lines else promised

    @property
    def lines_end_early(self) -> bool:
        """Whether less is known along the lines than is promised: what they lack of a constant's is no more than their own error, as of
        inertia beside a mass. It takes sensitivities along the axes of both to go from the one to the other."""
        return self.lines is not None and self.lines.log_z < self.promise.log_z


def at_best(fitted: tuple[Hypothesis, ...], new: Hypothesis) -> tuple[Hypothesis, ...]:
    """Each set once, at its best."""
    old = next((h for h in fitted if h.labels == new.labels), None)
    if old is not None and old.log_z >= new.log_z:
        return fitted
    return (*(h for h in fitted if h is not old), new)


@dataclass(frozen=True, slots=True)
class EvidenceSearch:
    """`nominal`: the rig file's own constants. `fitted`: every set fitted. `waiting`: sets that were not worth a fit so far."""

    rig: Rig
    channels: frozenset[str]
    seen: Seen
    nominal: Hypothesis
    fitted: tuple[Hypothesis, ...]
    waiting: tuple[Open, ...]
    log_odds: float  # of every suspect, before anything is seen

    @property
    def best(self) -> Hypothesis:
        """The set with the largest share of the posterior."""
        return self.fitted[int(np.argmax(self.shares))]

    @property
    def shares(self) -> list[float]:
        """Of the posterior over what is fitted, set by set."""
        return bootstrapped([self.weight(h) for h in self.fitted])

    @property
    def null(self) -> Hypothesis:
        """The set of none."""
        return self.fit_of(frozenset())

    @property
    def weights(self) -> dict[frozenset[str], Weight]:
        """Of all sets met, by the logs that are fitted. Those that only wait have what they promise, which is as far below the best set in
        every window: nothing is known of single ones."""
        found, best = {h.labels: self.weight(h) for h in self.fitted}, self.best
        promised = {w.labels: w for w in sorted(self.waiting, key=self.log_hope) if w.labels not in found}
        return found | {labels: replace(found[best.labels], log_mass=self.log_hope(w)) for labels, w in promised.items()}

    @property
    def posterior(self) -> Shares:
        """Over all sets met, by the logs that are fitted."""
        return of_weights(self.weights)

    def weight(self, hypothesis: Hypothesis) -> Weight:
        """Of a fitted set, by the logs that are fitted."""
        return Weight(self.log_mass(hypothesis), hypothesis.windows)

    def log_mass(self, hypothesis: Hypothesis) -> float:
        """ln π(S) Z of a fitted set, up to what all sets share."""
        return hypothesis.log_z + len(hypothesis.suspects) * self.log_odds

    def log_hope(self, waiting: Open) -> float:
        """The same of a set that waits."""
        return self.log_mass_with(waiting, waiting.gain)

    def log_mass_with(self, waiting: Open, gain: float) -> float:
        """The same, were that its gain over its base as it is fitted now."""
        return self.fit_of(waiting.base.labels).log_z + gain + len(waiting.labels) * self.log_odds

    def fit_of(self, labels: frozenset[str]) -> Hypothesis:
        """The fit of a set that has one."""
        found = self.known(labels)
        assert found is not None
        return found

    def known(self, labels: frozenset[str]) -> Hypothesis | None:
        """The fit of a set, if there is one."""
        return next((h for h in self.fitted if h.labels == labels), None)

    def reached(self, chosen: Open, done: Hypothesis) -> EvidenceSearch:
        """The search with a set that waited fitted; what promises no more of it than that waits no longer."""
        rest = (w for w in self.waiting if w is not chosen)
        waiting = tuple(w for w in rest if w.labels != done.labels or self.log_hope(w) > self.log_mass(done))
        return replace(self, waiting=waiting, fitted=at_best(self.fitted, done))

    def at_its_end(self, needed: Sequence[Hypothesis]) -> EvidenceSearch:
        """Only the sets that are needed keep their sensitivities, most of the memory of a search; what all of them say or promise stays."""
        kept = {h.labels for h in needed}
        fitted = tuple(h if h.labels in kept else _light(h) for h in self.fitted)
        waiting = tuple(replace(w, base=_light(w.base), promise=replace(w.promise, signature=None)) for w in self.waiting)
        return replace(self, nominal=_light(self.nominal), fitted=fitted, waiting=waiting)

    def suspects_beside(self, base: Hypothesis) -> list[Suspect]:
        """What may be added to a set: not what it has; nor an effect and the change of a number that is the same."""
        every: list[Suspect] = [*candidates(base.model.rig, self.channels), *changeable(self.rig, self.nominal.model.free)]
        return [suspect for suspect in every if suspect.label not in base.labels]


def _light(hypothesis: Hypothesis) -> Hypothesis:
    return replace(hypothesis, at=replace(hypothesis.at, readings=(), jacobian=()))
