"""Where a new best set is compared with its rivals beside what is integrated out about it, each fitted as far, one of them may be ahead."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.evidence import stages
from gap.evidence.search_state import EvidenceSearch
from tests.support.gap.bare_fit import bare_fit

NONE, SATURATION, BIAS = "", "saturation", "null bias"

# ln Z of sets, by what they are beside (case 0084 of the second study).
FIRST = {NONE: 525.0, SATURATION: 649.0, BIAS: 698.0}
BESIDE_BIAS = {NONE: -3400.0, SATURATION: -2610.0, BIAS: -2671.0}
BESIDE_SATURATION = {NONE: -2165.0, SATURATION: -1544.0, BIAS: -1599.0}


def fit(label: str, log_z: float) -> Any:
    found = bare_fit({label} - {NONE}, log_z)
    found.at = label
    return found


def searched(monkeypatch: pytest.MonkeyPatch, fitted_on: float) -> EvidenceSearch:
    """The search about its new best set, BIAS. `fitted_on`: ln Z beside the constants alone to which SATURATION's fit from BIAS' leads."""
    beside: Any = {"constants": FIRST | {SATURATION: fitted_on}, BIAS: BESIDE_BIAS, SATURATION: BESIDE_SATURATION}

    def again(seen: str, hypothesis: Any) -> Any:
        return fit(hypothesis.at, beside[seen][hypothesis.at])

    monkeypatch.setattr(stages, "beyond", lambda seen, before: np.array([5.0]))
    monkeypatch.setattr(stages, "about_fit", lambda seen, best: best.at)
    monkeypatch.setattr(stages, "side_by_side", lambda seen, work, items: [work(item) for item in items])
    monkeypatch.setattr(stages, "reweighed", again)
    monkeypatch.setattr(stages, "_followed", again)
    monkeypatch.setattr(stages, "at_own_constants", lambda search, there: there)
    monkeypatch.setattr(stages, "descended", lambda seen, at: at)
    monkeypatch.setattr(stages, "hypothesis_of", lambda seen, suspects, at: fit(at, beside[seen][at]))
    monkeypatch.setattr(stages, "from_magnitudes", lambda search, best: search)
    first = tuple(fit(label, log_z) for label, log_z in FIRST.items())
    seen: Any = "constants"
    search = EvidenceSearch(SimpleNamespace(), frozenset(), seen, first[0], first, (), -4.6)  # type: ignore[arg-type]
    return stages._about_best(search, first[0])


def test_a_rival_that_is_ahead_where_it_is_fitted_as_far_is_the_best_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """A saturation, stopped 96 short of its end, was overtaken by a null bias, which was confirmed for it."""
    search = searched(monkeypatch, 745.0)
    assert (search.seen, search.best.at, search.best.log_z) == (SATURATION, SATURATION, -1544.0)


def test_one_that_is_ahead_only_beside_the_best_sets_own_unknowns_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """A link that bends gives every window a start to vibrate from, also to a set whose link is rigid."""
    search = searched(monkeypatch, 650.0)
    assert (search.seen, search.best.at, search.best.log_z) == ("constants", BIAS, 698.0)
