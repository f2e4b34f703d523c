"""What the logs say of every suspect: shares of the posterior over sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gap.evidence.deciding_numbers import ALIKE_MASS
from gap.evidence.score.bootstrap import Weight, bootstrapped
from gap.evidence.score.hypothesis import Hypothesis
from gap.evidence.search_state import EvidenceSearch


@dataclass(frozen=True, slots=True)
class Shares:
    """Posterior share of every set, by its labels."""

    of_set: Mapping[frozenset[str], float]

    def of(self, label: str) -> float:
        """P(suspect ∈ S)."""
        return float(sum(share for labels, share in self.of_set.items() if label in labels))

    @property
    def none(self) -> float:
        """P(S = ∅)."""
        return self.of_set.get(frozenset(), 0.0)

    def in_place_of(self, best: frozenset[str], label: str) -> list[tuple[str, float]]:
        """The smallest group of suspects, exchangeable for `label` in the best set, that holds ALIKE_MASS of what the set has with any of
        them, each with its share of that; `label` among them, the largest share first."""
        rest = best - {label}
        rivals = {next(iter(labels - rest)): share for labels, share in self.of_set.items() if rest < labels and len(labels) == len(best)}
        total = sum(rivals.values())
        found: list[tuple[str, float]] = []
        held = 0.0
        for name, share in sorted(rivals.items(), key=lambda item: -item[1]):
            if held >= ALIKE_MASS * total and label in {n for n, _ in found}:
                break
            found.append((name, share / total))
            held += share
        return found


def shares(search: EvidenceSearch, judged: Mapping[frozenset[str], Hypothesis] | None = None, nested: Sequence[Hypothesis] = ()) -> Shares:
    """Over all sets met, those that only wait with what they promise. `judged`: sets fitted to all logs, the best set among them; the
    others are taken to gain with the hold-out what that one does. `nested`: sets as larger ones that are judged see them
    (gap.evidence.judgement.nested), which count where that is more."""
    best = search.best
    every = search.weights
    if judged:
        every = {labels: _gaining(weight, best, judged[best.labels]) for labels, weight in every.items()}
        every |= {labels: search.weight(h) for labels, h in judged.items()}
    for hypothesis in nested:
        weight, known = search.weight(hypothesis), every.get(hypothesis.labels)
        every[hypothesis.labels] = max(filter(None, (known, weight)), key=lambda w: w.log_mass)
    return Shares(dict(zip(every, bootstrapped(list(every.values())), strict=True)))


def _gaining(weight: Weight, before: Hypothesis, after: Hypothesis) -> Weight:
    """The weight that a set would have, did more logs say of it what they say of another one."""
    windows = after.windows.copy()
    windows[: len(before.windows)] += weight.windows - before.windows
    return Weight(weight.log_mass + after.log_z - before.log_z, windows)
