"""A closed gap does not vouch for every name: one of no certain size, or that the others hardly need, stays tentative."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap.fitting.evaluation import mean_cost
from gap.outcome.findings import finding
from gap.outcome.model_file import width_key
from gap.search.acceptance import without
from gap.search.search_state import GateSearch
from gap.search.verdict import CLOSED, Verdict, confidence, verdict
from gap.search.weak_names import weighed
from tests.support.gap.finished_search import finished, quiet


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    """With a dead band whose interval holds nothing."""
    return finished(tmp_path_factory.mktemp("weak"), size=1e-5)


def half_width(state: GateSearch) -> np.ndarray:
    return confidence(state.current, state.costs)


def of_steps(state: GateSearch, word: Verdict) -> list[bool]:
    widths = {
        width_key(step, state.current.model.free[k].key): 0.1 for step in state.steps for k in state.current.model.of_effect(step.entry)
    }
    return [finding(state, step, state.current.model, widths, word)["confirmed"] for step in state.steps]


def test_an_effect_whose_interval_holds_nothing_is_not_confirmed_beside_one_that_closes_the_gap(state: GateSearch) -> None:
    assert state.cost < CLOSED
    found = weighed(state, half_width(state), quiet)
    friction, deadband = found.steps
    assert friction.weak == ""
    assert deadband.weak.startswith("may be nothing (overlap ")
    word = verdict(found, 300.0, 200.0, found.cost)
    assert word.confirmed
    assert "valve_deadband at axis may be nothing" in word.why
    assert of_steps(found, word) == [True, False]


def test_an_effect_of_certain_size_that_the_others_hardly_need_is_not_confirmed(state: GateSearch) -> None:
    sure = np.full(len(state.current.model.free), 1e-12)
    found = weighed(state, sure, quiet)
    assert found.steps[0].weak == ""
    assert found.steps[1].weak.startswith("is hardly needed (hold-out without it ")


def test_the_only_name_is_weighed_against_constants_fitted_on_from_its_place(state: GateSearch) -> None:
    """What the verdict has beside it, the first fit of the constants, ended at far more."""
    sure = np.full(len(state.current.model.free), 1e-12)
    (alone,) = weighed(replace(state, steps=state.steps[1:]), sure, quiet).steps
    assert mean_cost(state.constants_only) > 10.0
    assert alone.weak.startswith("is hardly needed (hold-out without it ")


def test_the_rest_without_an_effect_is_fitted_once(state: GateSearch) -> None:
    knowing, rest = without(state, state.steps[1].entry)
    assert rest is not None
    assert without(knowing, state.steps[1].entry)[1] is rest
    moved = replace(knowing, current=replace(state.current))
    assert without(moved, state.steps[1].entry)[1] is not rest


def test_names_of_an_open_gap_are_not_weighed(state: GateSearch) -> None:
    wide = replace(state, seen=tuple(replace(e, window_costs=10.0 * e.window_costs) for e in state.seen))
    assert weighed(wide, half_width(state), quiet) is wide
    assert not verdict(wide, 300.0, 200.0, wide.cost).confirmed
