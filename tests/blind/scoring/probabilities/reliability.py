"""`python -m tests.blind.scoring.probabilities.reliability STUDY [--picture FILE]`: of names said with a probability, how many were
right.

Every name of a study counts once, by itself: a look-alike that is right makes no name right. Probabilities are put into bins; if they are
what they say, the number of right ones in a bin is a sum of coins of these probabilities. `may be`: the 95 % interval of a binomial of
their mean, a little wider than that sum's. Under `unknown` nothing is named, and a lead's probability is one among known effects where
something else acts: leads are counted by themselves, in the second table. Prints Markdown tables.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from gap.outcome.findings import explanations
from gap.report.reliability import LEAD, RIGHT_OF, SUREST, places
from tests.blind.cases import Case
from tests.blind.result_file import results
from tests.blind.scoring import tables
from tests.blind.scoring.pictures import plt, save
from tests.blind.scoring.wilson import wilson
from tests.blind.seal import unseal

EDGES = (0.5, 0.8, 0.95, 0.99, 1.0)
HEAD = ("said with", "names", "mean of what was said", "right", "share (95 %)", "may be")


@dataclass(frozen=True, slots=True)
class SaidName:
    """One name with its probability, whether it is one of those hidden, and where it stands (gap.report.reliability)."""

    probability: float
    right: bool
    place: str = SUREST


@dataclass(frozen=True, slots=True)
class Bin:
    """Names with probabilities in one range. `may_be`: numbers of right ones that are to be expected in 95 of 100 studies."""

    low: float
    high: float
    names: int
    mean: float
    right: int
    may_be: tuple[int, int]

    @property
    def kept(self) -> bool:
        """Whether as many were right as was said."""
        return self.may_be[0] <= self.right <= self.may_be[1]


def said_names(cases: Mapping[str, Case], found: Mapping[str, Mapping[str, Any]]) -> list[SaidName]:
    """Of all results, findings and leads; those without a probability (what the values of a log show by themselves) are left out."""
    return [name for case, result in found.items() for name in _of_result(cases[case], result)]


def _of_result(case: Case, result: Mapping[str, Any]) -> list[SaidName]:
    sure = [item for item in explanations(result) if item.get("probability") is not None]
    where = places(result["verdict"], [item["probability"] for item in sure])
    return [
        SaidName(float(item["probability"]), (item["effect"], item["where"]) in case.truth, place)
        for item, place in zip(sure, where, strict=True)
    ]


def by_place(names: Sequence[SaidName]) -> dict[str, dict[float, tuple[int, int]]]:
    """Of the names in every place, from a probability on up to the next: those that were right, and all."""
    return {place: {least: _right(names, place, least, below) for least, below in ((0.99, 1.01), (0.5, 0.99))} for place in RIGHT_OF}


def _right(names: Sequence[SaidName], place: str, least: float, below: float) -> tuple[int, int]:
    own = [name.right for name in names if name.place == place and least <= name.probability < below]
    return sum(own), len(own)


def table_by_place(names: Sequence[SaidName]) -> list[str]:
    """Row by row."""
    rows = [[place, *(f"{right} of {said}" for right, said in reversed(counts.values()))] for place, counts in by_place(names).items()]
    return tables.table(("", "right of those said with 0.5 to 0.99", "with 0.99 and more"), rows).splitlines()


def bins(names: Sequence[SaidName]) -> list[Bin]:
    """Names by what was said of them, the least sure first, without leads; empty bins are left out."""
    made, named = [], [n for n in names if n.place != LEAD]
    for low, high in pairwise(EDGES):
        own = [n for n in named if low <= n.probability < high or (high == EDGES[-1] and n.probability == high)]
        if own:
            mean = float(np.mean([n.probability for n in own]))
            least, most = binom.interval(0.95, len(own), mean)
            made.append(Bin(low, high, len(own), mean, sum(n.right for n in own), (int(least), int(most))))
    return made


def table(made: Sequence[Bin]) -> list[str]:
    """Row by row."""
    return tables.table(HEAD, [_row(b) for b in made]).splitlines()


def _row(b: Bin) -> list[str]:
    low, high = wilson(b.right, b.names)
    share = f"{b.right / b.names:.3f} ({low:.3f} to {high:.3f})"
    return [f"{b.low:g} to {b.high:g}", f"{b.names}", f"{b.mean:.3f}", f"{b.right}", share, f"{b.may_be[0]} to {b.may_be[1]}"]


def diagram(made: Sequence[Bin], path: Path) -> None:
    """Share of right names over what was said, with Wilson's intervals; on the diagonal a probability is what it says."""
    figure, axes = plt.subplots(figsize=(4, 3.6))
    axes.plot([0.5, 1.0], [0.5, 1.0], color="grey", linewidth=0.8, label="as said")
    for b in made:
        low, high = wilson(b.right, b.names)
        axes.plot([b.mean, b.mean], [low, high], color="tab:blue")
        axes.plot(b.mean, b.right / b.names, "o", color="tab:blue", markersize=4)
        axes.annotate(f"{b.right} of {b.names}", (b.mean, low), textcoords="offset points", xytext=(-4, -9), ha="right", fontsize=7)
    axes.set_xlabel("probability said of a name (mean of its bin)")
    axes.set_ylabel("share of right names, 95 % interval")
    axes.legend(fontsize=8)
    save(figure, path)


def main() -> int:
    """Exit 0 if every bin is within what was said, else 1."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.scoring.probabilities.reliability", description=__doc__)
    parser.add_argument("study", type=Path, help="folder of the study by evidence")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="also draw the reliability diagram (PNG)")
    arguments = parser.parse_args()
    names = said_names({case.name: case for case in unseal(arguments.study)}, results(arguments.study))
    made = bins(names)
    print("\n".join([*table(made), "", *table_by_place(names)]))
    if arguments.picture:
        diagram(made, arguments.picture)
    return 0 if all(b.kept for b in made) else 1


if __name__ == "__main__":
    raise SystemExit(main())
