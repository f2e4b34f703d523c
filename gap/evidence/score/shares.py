"""The posterior over sets, and what it says of single suspects."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass

from gap.evidence.deciding_numbers import ALIKE_MASS, CONFIRMED
from gap.evidence.score.bootstrap import Weight, bootstrapped


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

    def between(self, label: str, fitted: Set[frozenset[str]]) -> Set[frozenset[str]]:
        """The sets without a name that are not `fitted`, if what they promise is all that keeps it from being confirmed."""
        lacking = {labels: share for labels, share in self.of_set.items() if label not in labels}
        known = sum(share for labels, share in lacking.items() if labels in fitted)
        return lacking.keys() - fitted if known <= 1.0 - CONFIRMED < sum(lacking.values()) else frozenset()

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


def of_weights(weights: Mapping[frozenset[str], Weight]) -> Shares:
    """The shares of sets by what the logs say of them."""
    return Shares(dict(zip(weights, bootstrapped(list(weights.values())), strict=True)))
