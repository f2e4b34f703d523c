"""Fits begun before it is known whether they are asked for: of the set that waits next, beside the one that is asked.

While no better set is found the next one is asked under the same conditions, so its fit is the one that would have been made then. Else it
is forgotten. What is found does not hang on the number of threads, only how soon.
"""

from __future__ import annotations

from dataclasses import dataclass

from gap.evidence.score.hypothesis import Hypothesis
from gap.evidence.search_state import EvidenceSearch, Open
from gap.evidence.set_fits import refined
from gap.evidence.side_by_side import side_by_side


@dataclass(frozen=True, slots=True)
class Ahead:
    """The fit of a set that waits, and the search in which it was made."""

    search: EvidenceSearch
    waiting: Open
    done: Hypothesis

    def holds(self, search: EvidenceSearch, asked: Open) -> bool:
        """Whether it is the fit that is asked for now: the set is the same, and all that its fit looks at."""
        was, base = self.search, asked.base.labels
        same_logs = asked is self.waiting and search.seen is was.seen
        return same_logs and search.fit_of(base) is was.fit_of(base) and search.log_mass(search.best) == was.log_mass(was.best)


def fitted(search: EvidenceSearch, asked: Open, after: Open | None, known: Ahead | None) -> tuple[Hypothesis, Ahead | None]:
    """The fit of the set that is asked, and that of the one `after` it, where there is a thread for it; `known`: begun before."""
    if known is not None and known.holds(search, asked):
        return known.done, None
    if after is None or search.seen.threads < 2:
        return refined(search, asked), None
    done, other = side_by_side(search.seen, lambda waiting: refined(search, waiting), (asked, after))
    return done, Ahead(search, after, other)
