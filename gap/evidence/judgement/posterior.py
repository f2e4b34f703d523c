"""The posterior once the hold-out has been asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gap.evidence.score.bootstrap import Weight
from gap.evidence.score.hypothesis import Hypothesis
from gap.evidence.score.shares import Shares, of_weights
from gap.evidence.search_state import EvidenceSearch


def of_all_logs(search: EvidenceSearch, judged: Mapping[frozenset[str], Hypothesis], nested: Sequence[Hypothesis] = ()) -> Shares:
    """Over all sets met, those that only wait with what they promise. `judged`: sets fitted to all logs, the best set among them; the
    others are taken to gain with the hold-out what that one does. `nested`: sets as larger ones that are judged see them
    (gap.evidence.judgement.nested), which count where that is more."""
    best = search.best
    every = {labels: _gaining(weight, best, judged[best.labels]) for labels, weight in search.weights.items()}
    every |= {labels: search.weight(h) for labels, h in judged.items()}
    for hypothesis in nested:
        weight, known = search.weight(hypothesis), every.get(hypothesis.labels)
        every[hypothesis.labels] = max(filter(None, (known, weight)), key=lambda w: w.log_mass)
    return of_weights(every)


def _gaining(weight: Weight, before: Hypothesis, after: Hypothesis) -> Weight:
    """The weight that a set would have, did more logs say of it what they say of another one."""
    windows = after.windows.copy()
    windows[: len(before.windows)] += weight.windows - before.windows
    return Weight(weight.log_mass + after.log_z - before.log_z, windows)
