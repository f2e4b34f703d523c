"""Where lines do not hold, all promises from that start are empty; that says nothing of promises from another one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gap.evidence import stages
from gap.evidence.search_state import EvidenceSearch, Open
from tests.support.gap.bare_fit import bare_fit as fit

TRUE, EMPTY, HONEST = "true", "empty", "honest"


def promised(label: str, gain: float, level: float) -> Open:
    promise: Any = SimpleNamespace(suspect=SimpleNamespace(label=label), log_z=gain)
    return Open(fit(set(), 0.0), promise, None, (0.0, 0.0), level)


def decided(monkeypatch: pytest.MonkeyPatch, promises: list[Open], gains: dict[str, float]) -> tuple[EvidenceSearch, list[str]]:
    """The search with what was fitted, and in which order; what has no gain loses one."""
    asked: list[str] = []

    def fitted(search: Any, first: Open, after: Any, ahead: Any) -> tuple[Any, None]:
        (label,) = first.labels
        asked.append(label)
        return fit({label}, gains.get(label, -1.0)), None

    monkeypatch.setattr(stages, "fitted", fitted)
    monkeypatch.setattr(stages, "part_of", lambda *_: None)
    monkeypatch.setattr(stages, "less", lambda search, done, part: search)
    none, anything = fit(set(), 0.0), SimpleNamespace()
    search = EvidenceSearch(anything, frozenset(), anything, none, (none,), tuple(promises), -4.0)  # type: ignore[arg-type]
    return stages._decided(search, none, lambda line: None, 0), asked


def test_empty_promises_of_one_start_leave_those_of_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """Case 0113 of the second study: eight suspects were promised up to 68 along lines from the rig file's own constants, and fitted to
    nothing; Coulomb friction of a third of its stated size, promised 7.4 from the fitted ones, was not asked for."""
    far = [promised(f"{EMPTY} {k}", 20.0 + k, -150.0) for k in range(8)]
    search, asked = decided(monkeypatch, [*far, promised(TRUE, 7.4, 0.0)], {TRUE: 7.1})
    assert asked[-1] == TRUE
    assert len(asked) == stages._PATIENCE + 1
    assert search.best.labels == {TRUE}


def test_what_was_not_believed_holds_no_share(monkeypatch: pytest.MonkeyPatch) -> None:
    far = [promised(f"{EMPTY} {k}", 20.0 + k, -150.0) for k in range(8)]
    small = promised(HONEST, 3.0, -150.0)
    search, asked = decided(monkeypatch, [*far, small], {})
    assert len(asked) == stages._PATIENCE
    assert search.waiting == (small,)  # no more than the best set has
