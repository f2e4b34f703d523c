"""When the constants' fit is taken on before anything is looked for."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gap.fitting.evaluation import NO_GAP, evaluate, mean_cost
from gap.search.held_at_priors import search_held_at_priors
from gap.search.search_state import GateSearch
from tests.support.gap import axis_logs
from tests.support.gap.finished_search import fitted
from tests.support.gap.small_friction import OWN_N, Log, opened


@pytest.fixture(scope="module")
def beside_its_place(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    """A rig file with half a percent too much mass, refitted, and the fit's mass then moved a little from where it is best."""
    text = axis_logs.axis_text().replace("mass: 95.1089 kg", "mass: 95.6 kg")
    state = opened(tmp_path_factory.mktemp("taken_on"), Log(OWN_N, 1, 5.0), Log(OWN_N, 2, 3.0), text=text)
    model, theta = state.current.model, state.current.model.theta.copy()
    theta[[free.key for free in model.free].index("plant.joints.axis.mass")] *= 1.00087
    return replace(state, current=fitted(state, model.with_theta(theta)))


@pytest.mark.parametrize(("holdout", "taken_on"), [(1.01, False), (1.099, True)], ids=["predicts the hold-out", "does not"])
def test_a_good_fit_is_left_alone_only_where_it_predicts(beside_its_place: GateSearch, holdout: float, taken_on: bool) -> None:
    """Else a candidate's fit, from a better place, would sell what it takes as the effect's."""
    state = beside_its_place
    assert 1.0 < state.current.cost < NO_GAP
    seen = [evaluate(e, state.current.model, state.costs) for e in state.holdouts]
    share = holdout / mean_cost(seen)
    state = replace(state, seen=tuple(replace(e, window_costs=share * e.window_costs) for e in seen))
    told: list[str] = []
    found = search_held_at_priors(state, told.append)
    assert any(line.startswith("constants fitted further: hold-out 1.099") for line in told) is taken_on
    assert (found.current is state.current) is not taken_on
    assert found.steps == ()
