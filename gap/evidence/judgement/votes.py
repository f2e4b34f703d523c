"""Two votes on a name, the logs' roles exchanged: the hold-out B judges what the fit logs A have fitted, and they judge what B has fitted.

    ln p(B | A, S) = ln Z(A, B) − ln Z(A)          ln p(A | B, S) = ln Z(A, B) − ln Z(B)

Each is taken of the set with the name less that of the set without it. Only ln Z(B) is new: every set that is asked about is fitted on
from all logs to the hold-out alone. A set was searched for on A only, so the second vote is not blind: it asks whether A bears out the
sizes that B wants, and speaks against a name whose sizes differ from log to log.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from gap.evidence.refinement import descended, hypothesis_of
from gap.evidence.score.hypothesis import Hypothesis, Seen
from gap.evidence.side_by_side import side_by_side


@dataclass(frozen=True, slots=True)
class Votes:
    """By how much the logs that were not fitted are more probable with a name than without it (ln): `holdout`, when the fit logs are
    fitted; `fit_logs`, when the hold-out is."""

    holdout: float
    fit_logs: float


class Ballot:
    """Sets by what each log says of them. `fitted`: to the fit logs, `on_all`: to all logs, by their labels."""

    def __init__(
        self, seen: Seen, held: Seen, fitted: Mapping[frozenset[str], Hypothesis], on_all: Mapping[frozenset[str], Hypothesis]
    ) -> None:
        self._seen, self._held, self._fitted, self._on_all = seen, held, fitted, on_all
        self._alone: dict[frozenset[str], Hypothesis] = {}

    def fitted(self, labels: frozenset[str]) -> bool:
        """Whether there is a fit of a set: what only waits is not called like a name."""
        return labels in self._fitted

    def votes(self, with_it: frozenset[str], without: frozenset[str]) -> Votes | None:
        """For what a set has more than another one; than none where the hold-out was not asked about that. None where it was not asked
        about the first."""
        if with_it not in self._on_all:
            return None
        less = without if without in self._on_all else frozenset()
        (holdout, fit_logs), (holdout_without, fit_logs_without) = side_by_side(self._seen, self._of_others, (with_it, less))
        return Votes(holdout - holdout_without, fit_logs - fit_logs_without)

    def _of_others(self, labels: frozenset[str]) -> tuple[float, float]:
        """ln p of the hold-out with the set fitted to the fit logs, and the other way round."""
        whole = self._on_all[labels]
        if labels not in self._alone:
            self._alone[labels] = on_hold_out(self._seen, whole, self._held)
        return whole.log_z - self._fitted[labels].log_z, whole.log_z - self._alone[labels].log_z


def on_hold_out(seen: Seen, judged: Hypothesis, held: Seen) -> Hypothesis:
    """A set fitted to the hold-out alone, from where all logs have led it. The hold-out counts as it does among all logs."""
    number, at = len(seen.experiments), judged.at
    discrepancy = replace(at.discrepancy, times=at.discrepancy.times[number:])
    point = replace(at, readings=at.readings[number:], jacobian=at.jacobian[number:], discrepancy=discrepancy)
    return hypothesis_of(held, judged.suspects, descended(held, point))
