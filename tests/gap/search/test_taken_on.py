"""When the constants' fit is taken on before anything is looked for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gap.fitting.evaluation import NO_GAP
from gap.search import held_at_priors


@pytest.mark.parametrize(("holdout", "good"), [(1.01, NO_GAP), (1.099, 0.0)], ids=["predicts the hold-out", "does not"])
def test_a_good_fit_is_left_alone_only_where_it_predicts(monkeypatch: pytest.MonkeyPatch, holdout: float, good: float) -> None:
    """Else a candidate's fit, from a better place, would sell what it takes as the effect's."""
    asked: list[float] = []
    fitted = SimpleNamespace(cost=1.03)

    def polished(done: object, nominal: object, costs: object, least: float) -> tuple[object, object]:
        asked.append(least)
        return done, costs

    monkeypatch.setattr(held_at_priors, "polished", polished)
    state: Any = SimpleNamespace(current=fitted, cost=holdout, nominal=SimpleNamespace(evaluations=()), costs=None)
    assert held_at_priors._taken_on(state, lambda line: None) is state  # nothing was gained
    assert asked == [good]
