"""The last look at a finished model: what it does not need goes, what would do as well is told."""

from __future__ import annotations

from dataclasses import replace

import pytest
from finished_search import finished, quiet

from gap.search.last_look import last_look
from gap.search.search_state import Search


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> Search:
    return finished(tmp_path_factory.mktemp("look"), size=1e-5)


def test_what_the_model_does_not_need_goes_and_a_worse_rival_is_no_look_alike(state: Search) -> None:
    assert state.cost < 1.2
    before = state.cost
    found = last_look(replace(state, steps=list(state.steps)), quiet)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert [entry.effect for entry in found.current.model.added] == ["coulomb_friction"]
    assert found.current.model.theta[-1] == pytest.approx(20.39, rel=0.03)
    assert found.cost < before + 0.02
    assert found.steps[0].rivals == ()


def test_a_model_that_leaves_a_gap_is_left_alone(state: Search) -> None:
    wrong = replace(state, seen=tuple(replace(e, window_costs=10.0 * e.window_costs) for e in state.seen))
    steps = list(wrong.steps)
    assert last_look(wrong, quiet).steps == steps
