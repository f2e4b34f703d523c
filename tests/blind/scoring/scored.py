"""A study as far as it is run: cases, results and scores. To score it opens its seal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

from tests.blind.cases import Case
from tests.blind.result_file import results
from tests.blind.scoring.score import Score, score
from tests.blind.seal import published, unseal

Results = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class Scored:
    """`cases`: all that are sealed; `found`: results by the name of their case; `scores`: of the cases run, in the order of `cases`."""

    folder: Path
    cases: Sequence[Case]
    found: Results
    scores: Sequence[Score]

    @property
    def by_version(self) -> dict[str, Scored]:
        """The cases that each commit ran, in the order in which they ran."""
        commits = dict.fromkeys(str(r["commit"]) for r in sorted(self.found.values(), key=lambda r: str(r["date"])))
        return {commit: self._of({name: r for name, r in self.found.items() if r["commit"] == commit}) for commit in commits}

    def _of(self, found: Results) -> Scored:
        return replace(self, found=found, scores=[s for s in self.scores if s.case.name in found])

    @property
    def run_words(self) -> str:
        """What was run when by which commits, when it was sealed, and how long a search took."""
        digest, sealed = published(self.folder)
        if not self.found:
            return f"No case has been run yet. Answers {sealed}, SHA-256 `{digest}`."
        counts = Counter(s.case.group for s in self.scores)
        dates = sorted(str(r["date"]) for r in self.found.values())
        seconds = [float(r["processor_s"]) for r in self.found.values()]
        run = ", ".join(f"{counts[g]} {g.replace('_', ' ')}" for g in dict.fromkeys(case.group for case in self.cases))
        return (
            f"**{len(self.scores)} of {len(self.cases)} cases run** ({run}), {dates[0]} to {dates[-1]} UTC, "
            f"by commit {', '.join(self.by_version)}.\nAnswers {sealed}, SHA-256 `{digest}`, before the run.\n"
            f"A search took {median(seconds):.0f} s of processor time (median; longest {max(seconds):.0f} s)."
        )


def scored(study: Path) -> Scored:
    """Every case of `study` that has a result."""
    cases, found = unseal(study), results(study)
    return Scored(study, cases, found, [score(case, found[case.name]) for case in cases if case.name in found])
