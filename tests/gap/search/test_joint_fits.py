"""Before nothing is named: candidates fitted together with the constants, from the rig file's own."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.fitting.evaluation import recounted
from gap.search import joint_fits
from gap.search.joint_fits import CAUTION, look_jointly
from gap.search.search_state import GateSearch
from tests.support.gap.finished_search import finished, quiet

LEAST = 3.8


def log(costs: np.ndarray) -> Any:
    """As much of an evaluation as the gates look at: costs of windows of 70 values each."""
    return SimpleNamespace(window_costs=costs, experiment=SimpleNamespace(measured=np.zeros((len(costs), 70, 1))))


def ragged(mean: float, seed: int, spread: float = 0.05, windows: int = 30) -> Any:
    return log(mean * np.random.default_rng(seed).lognormal(0, spread, windows))


def judged(fit_cost: float, holdout: Any, drop: float = 0.3, sized: bool = True, gain: float = 0.3) -> Any:
    fit, cost = SimpleNamespace(evaluations=(ragged(fit_cost, 3),)), float(holdout.window_costs.mean())
    everywhere = (*fit.evaluations, holdout)
    return SimpleNamespace(fit=fit, holdout=(holdout,), everywhere=everywhere, cost=cost, drop=drop, gain=gain, has_size=sized)


def constants(fit_cost: float, holdout: float) -> Any:
    return SimpleNamespace(current=SimpleNamespace(evaluations=(ragged(fit_cost, 1),)), seen=(ragged(holdout, 2),), cost=holdout)


def test_both_kinds_of_logs_together_can_speak_for_an_effect() -> None:
    """As with a scale of 3 %: clear in the fit logs, and half of the hold-out's windows agree."""
    split = log(2.0 * np.tile([0.7, 0.7, 1.2], 10))
    without = (constants(2.0, 2.0),)
    assert joint_fits._agreed(judged(1.3, split), without, LEAST)
    assert not joint_fits._agreed(judged(2.0, split), without, LEAST)  # the hold-out by itself would not do


def test_the_hold_out_must_not_speak_against_it() -> None:
    worse = log(2.0 * np.tile([0.6, 1.6, 1.6], 10))
    assert not joint_fits._agreed(judged(1.3, worse), (constants(2.0, 2.0),), LEAST)


def test_a_fit_of_the_constants_that_has_stuck_proves_nothing() -> None:
    """It is judged beside the better one as well."""
    trial = judged(1.3, ragged(1.4, 4))
    assert joint_fits._agreed(trial, (constants(3.0, 3.0),), LEAST)
    assert not joint_fits._agreed(trial, (constants(3.0, 3.0), constants(1.3, 1.4)), LEAST)


@pytest.mark.parametrize(("drop", "sized"), [(0.05, True), (0.3, False)], ids=["takes too little", "its interval holds the neutral value"])
def test_agreement_alone_is_not_enough(drop: float, sized: bool) -> None:
    assert not joint_fits._agreed(judged(1.3, ragged(1.4, 4), drop, sized), (constants(2.0, 2.0),), LEAST)


def test_what_leaves_more_open_than_friction_of_another_form_is_no_explanation() -> None:
    """A cogging force: of 2.2e4 noise floors a sensor scale left a third."""
    assert joint_fits._agreed(judged(1.3, ragged(2.4, 4), drop=2.0), (constants(5.0, 5.0),), LEAST)
    assert not joint_fits._agreed(judged(1.3, ragged(2.6, 4), drop=2.0), (constants(5.0, 5.0),), LEAST)


def test_what_takes_most_of_a_large_gap_explains_it() -> None:
    """Pressure friction beside friction that slips otherwise than the model's: of 15.5 noise floors 2.7 were left."""
    assert joint_fits._agreed(judged(2.7, ragged(2.7, 4), drop=12.8, gain=0.88), (constants(15.5, 15.5),), LEAST)


def test_with_caution_samples_count_for_less() -> None:
    costs = SimpleNamespace(threshold=np.array([6.0]), tau=8.0, caution=CAUTION)
    experiment = SimpleNamespace(measured=np.zeros((40, 70, 1)))
    white = SimpleNamespace(experiment=experiment, left=np.random.default_rng(5).normal(size=(40, 70)))
    again = recounted(costs, [white])  # type: ignore[arg-type, list-item]
    assert again.tau == pytest.approx(CAUTION, rel=0.1)
    assert again.caution == CAUTION


@pytest.fixture(scope="module")
def state(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    return finished(tmp_path_factory.mktemp("joint_fits"), size=1e-5)


def test_a_friction_that_the_search_has_missed_is_named(state: GateSearch) -> None:
    """The search stands where it began, with no name: the refitted constants of a model without friction."""
    missed = replace(state, steps=(), current=state.nominal, seen=state.constants_only)
    found = look_jointly(missed, quiet)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert found.steps[0].weak == ""  # the hold-out alone would have done
    assert found.cost < 1.05
    assert found.costs.caution == CAUTION


def test_what_is_named_already_is_left_alone(state: GateSearch) -> None:
    assert look_jointly(state, quiet) is state


def test_where_no_effect_could_be_worth_anything_none_is_tried(state: GateSearch) -> None:
    """Its cost is at the floor: the model that has the friction."""
    assert look_jointly(replace(state, steps=()), quiet).steps == ()
