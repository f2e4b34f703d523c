"""An effect that a constant of the rig file stands for, within what that may be wrong by, is no name."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gap.fitting.evaluation import mean_cost
from gap.fitting.model import Model
from gap.search.absorbed import absorb, constant_instead
from gap.search.search_state import GateSearch
from tests.support.gap.finished_search import finished, fitted, quiet

MASS = "plant.joints.axis.mass"
MASS_KG, MASS_SD_KG = 95.1089, 0.02 * 95.1089  # [B]


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    """With 3 kg of extra mass beside the axis's own, which the truth has not: 1.6 standard deviations of what was known of that."""
    return finished(tmp_path_factory.mktemp("absorbed"), size=3.0, second="inertia_error")


def moved(state: GateSearch, mass_kg: float, extra_kg: float) -> GateSearch:
    """The same search with another mass and extra mass."""
    model = state.current.model
    theta = model.theta.copy()
    theta[number(model)] = mass_kg
    theta[model.of_effect(state.steps[1].entry)] = extra_kg
    return replace(state, current=fitted(state, model.with_theta(theta)))


def number(model: Model) -> int:
    return next(k for k, free in enumerate(model.free) if free.key == MASS)


def test_the_constant_in_the_effects_place_predicts_the_same(state: GateSearch) -> None:
    found = constant_instead(state.current, state.steps[1].entry)
    assert found is not None
    instead, key, pull = found
    assert key == MASS
    assert pull == pytest.approx(3.0 / MASS_SD_KG, rel=0.02)
    assert instead.model.theta[number(instead.model)] == pytest.approx(MASS_KG + 3.0, rel=1e-3)
    assert [entry.effect for entry in instead.model.added] == ["coulomb_friction"]
    assert fitted(state, instead.model).cost == pytest.approx(state.current.cost, rel=0.02)


def test_the_name_goes_and_the_constant_is_fitted(state: GateSearch) -> None:
    told: list[str] = []
    found = absorb(moved(state, MASS_KG, 3.0), told.append)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert f"dropped: inertia_error at axis is {MASS} within +1.6 prior standard deviations" in told
    assert found.current.model.theta[number(found.current.model)] == pytest.approx(MASS_KG, rel=0.002)
    assert mean_cost(found.seen) < 1.05


def test_what_the_constant_itself_has_moved_counts(state: GateSearch) -> None:
    """5 kg more than a mass that stands 3 kg too low are 2 kg; 5 kg more than the file's are no error of a constant known to 2 %."""
    low = constant_instead(moved(state, MASS_KG - 3.0, 5.0).current, state.steps[1].entry)
    assert low is not None
    assert low[2] == pytest.approx(2.0 / MASS_SD_KG, rel=0.05)
    assert constant_instead(moved(state, MASS_KG, 5.0).current, state.steps[1].entry) is None


def test_an_effect_that_no_constant_stands_for_stays(state: GateSearch) -> None:
    assert constant_instead(state.current, state.steps[0].entry) is None
    whole = absorb(moved(state, MASS_KG, 5.0), quiet)
    assert len(whole.steps) == 2


def test_constants_are_what_the_verdict_weighs_when_no_name_is_left(state: GateSearch) -> None:
    alone = absorb(replace(moved(state, MASS_KG, 3.0), steps=state.steps[1:]), quiet)
    assert alone.steps == ()
    assert alone.constants_only is alone.seen
    assert mean_cost(alone.constants_only) < 1.05
