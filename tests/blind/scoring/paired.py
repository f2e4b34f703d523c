"""`python -m tests.blind.scoring.paired A B`: two searches on the same cases, paired (McNemar), group by group.

Each has run them from a checkout of its own (`python -m tests.blind --study STUDY/A`), with answers that lie in STUDY, sealed once
(`python -m tests.blind --study STUDY --seal`), or in either folder the same.

A case that both searches have finished counts. p: how probable as many cases lost, of those that differ, would be if B were as good as A
(one-sided, exact). s: median of processor time where the results have it. Prints a Markdown table.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from tests.blind.cases import Case
from tests.blind.result_file import results
from tests.blind.scoring.score import QUIET, Score, right, score
from tests.blind.seal import unseal

HEAD = (
    "| group | cases | right A | right B | only A | only B | p (B worse) | quiet A | quiet B "
    "| wrong confirmed A | wrong confirmed B | s A | s B |"
)


@dataclass(frozen=True, slots=True)
class Pair:
    """One case by both searches."""

    a: Score
    b: Score
    seconds: tuple[float, float] = (np.nan, np.nan)  # of processor time

    @property
    def group(self) -> str:
        return self.a.case.group


def pairs(a: Path, b: Path) -> list[Pair]:
    """ValueError where a case of one name is not one case in both studies."""
    cases = [{case.name: case for case in unseal(study)} for study in (a, b)]
    found = [results(study) for study in (a, b)]
    common = sorted(set(found[0]) & set(found[1]))
    differing = [name for name in common if cases[0][name].as_json() != cases[1][name].as_json()]
    if differing:
        raise ValueError(f"other cases of the same name: {', '.join(differing)}; give both studies one --seed")
    return [_pair(cases[0][name], found[0][name], found[1][name]) for name in common]


def _pair(case: Case, a: dict[str, Any], b: dict[str, Any]) -> Pair:
    seconds = (float(a.get("processor_s", np.nan)), float(b.get("processor_s", np.nan)))
    return Pair(score(case, a), score(case, b), seconds)


def table(every: Sequence[Pair]) -> Iterator[str]:
    """Row by row, with all groups together last."""
    yield HEAD
    yield "|---" * (HEAD.count("|") - 1) + "|"
    for group in dict.fromkeys(pair.group for pair in every):
        yield _row(group, [pair for pair in every if pair.group == group])
    yield _row("all", every)


def worse(only_a: int, only_b: int) -> float:
    """P(as many or more of the differing cases lost | both as good): X ~ Bin(only_a + only_b, ½)."""
    return float(binom.sf(only_a - 1, only_a + only_b, 0.5))


def _row(group: str, some: Sequence[Pair]) -> str:
    a, b = [right(p.a) for p in some], [right(p.b) for p in some]
    only_a, only_b = sum(x and not y for x, y in zip(a, b, strict=True)), sum(y and not x for x, y in zip(a, b, strict=True))
    quiet = [sum(s.verdict in QUIET for s in side) for side in ([p.a for p in some], [p.b for p in some])]
    wrong = [sum(bool(s.wrong_confirmed) for s in side) for side in ([p.a for p in some], [p.b for p in some])]
    seconds = [f"{np.median(side):.1f}" for side in zip(*(p.seconds for p in some), strict=True)]
    numbers = (len(some), sum(a), sum(b), only_a, only_b, f"{worse(only_a, only_b):.3f}", *quiet, *wrong, *seconds)
    return f"| {group} | " + " | ".join(map(str, numbers)) + " |"


def main() -> int:
    """Exit 0."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.scoring.paired", description=__doc__)
    parser.add_argument("a", type=Path, help="folder of the study with one search")
    parser.add_argument("b", type=Path, help="folder of the study with the other")
    arguments = parser.parse_args()
    print("\n".join(table(pairs(arguments.a, arguments.b))))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
