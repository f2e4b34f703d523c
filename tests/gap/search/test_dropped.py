"""An accepted effect that is worth nothing any more leaves again, the newest included."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gap.fitting.evaluation import mean_cost
from gap.search.acceptance import drop_superfluous
from gap.search.search_state import GateSearch
from tests.support.gap.finished_search import finished, quiet


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    """Friction that is missing in the rig file, then a dead band that does nothing."""
    return finished(tmp_path_factory.mktemp("dropped"), size=1e-5)


def test_the_newest_goes_where_the_model_does_as_well_without_it(state: GateSearch) -> None:
    told: list[str] = []
    found = drop_superfluous(state, told.append)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert [entry.effect for entry in found.current.model.added] == ["coulomb_friction"]
    assert any(line.startswith("dropped: valve_deadband at axis explains nothing") for line in told)
    assert found.cost < 1.05


def test_what_is_needed_stays_also_as_the_newest(state: GateSearch) -> None:
    turned = drop_superfluous(replace(state, steps=state.steps[::-1]), quiet)
    assert [step.trial.candidate.effect for step in turned.steps] == ["coulomb_friction"]


def test_without_any_name_the_verdict_weighs_the_constants_it_led_to(state: GateSearch) -> None:
    """The constants may be far better off than before the effect: it had brought them to another place."""
    assert mean_cost(state.constants_only) > 10.0
    alone = drop_superfluous(replace(state, steps=state.steps[1:]), quiet)
    assert alone.steps == ()
    assert alone.constants_only is alone.seen
    assert mean_cost(alone.constants_only) < 1.05
