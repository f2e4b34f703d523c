"""The last look at a finished model: what it does not need goes, what would do as well is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gap.search.final_weighing import weighed_finally
from gap.search.search_state import GateSearch
from tests.support.gap import axis_logs
from tests.support.gap.finished_search import finished, quiet


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    return finished(tmp_path_factory.mktemp("look"), size=1e-5)


def test_what_the_model_does_not_need_goes_and_a_worse_rival_is_no_look_alike(state: GateSearch) -> None:
    assert state.cost < 1.2
    before = state.cost
    found = weighed_finally(state, quiet)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert [entry.effect for entry in found.current.model.added] == ["coulomb_friction"]
    assert found.current.model.theta[-1] == pytest.approx(20.39, rel=0.03)
    assert found.cost < before + 0.02
    assert found.steps[0].rivals == ()


def test_a_rival_that_a_later_effect_has_shown_to_be_worse_is_no_look_alike_any_more(tmp_path: Path) -> None:
    """A dead band stood beside Coulomb friction while viscous friction was missing; beside both frictions it explains nothing."""
    found = finished(tmp_path, 203.5, "viscous_friction", axis_logs.axis_text("coulomb_friction", "viscous_friction"))
    friction, viscous = found.steps
    looked = weighed_finally(replace(found, steps=(replace(friction, rivals=friction.others), viscous)), quiet)
    assert [step.trial.candidate.effect for step in looked.steps] == ["coulomb_friction", "viscous_friction"]
    assert [step.rivals for step in looked.steps] == [(), ()]


def test_a_model_that_leaves_a_gap_is_left_alone(state: GateSearch) -> None:
    wrong = replace(state, seen=tuple(replace(e, window_costs=10.0 * e.window_costs) for e in state.seen))
    assert weighed_finally(wrong, quiet) is wrong
