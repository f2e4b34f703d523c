"""Before nothing is named: candidates fitted together with the constants, from the rig file's own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gap.fitting.evaluation import evaluate, recounted
from gap.search.joint_fits import CAUTION, look_jointly
from gap.search.search_state import GateSearch
from tests.support.gap.finished_search import finished, fitted, quiet
from tests.support.gap.small_friction import Log, opened


def named(state: GateSearch) -> list[tuple[str, bool]]:
    """The names that are found, and whether each rests on the fit logs more than on the hold-out."""
    steps = look_jointly(state, quiet).steps
    return [(step.trial.candidate.effect, step.weak.startswith("rests on the fit logs more than on the hold-out (t = ")) for step in steps]


@pytest.mark.slow
def test_both_kinds_of_logs_together_can_speak_for_an_effect(tmp_path: Path) -> None:
    """12 s of the fit log show 0.2 N clearly; 2 s of hold-out would not do by themselves."""
    assert named(opened(tmp_path, Log(0.2, 1), Log(0.2, 2, 2.0))) == [("coulomb_friction", True)]


@pytest.mark.slow
@pytest.mark.parametrize("friction_N", [0.0, 0.05])
def test_the_hold_out_by_itself_is_not_enough(tmp_path: Path, friction_N: float) -> None:
    """The fit log has nothing of it (the interval holds 0), or too little beside 2 s of hold-out."""
    assert named(opened(tmp_path, Log(friction_N, 1), Log(0.2, 2, 2.0))) == []


@pytest.mark.slow
def test_the_hold_out_must_not_speak_against_it(tmp_path: Path) -> None:
    """Its mean falls with the friction of the fit log; but in as many of its windows as have friction there is none."""
    assert named(opened(tmp_path, Log(0.15, 1), Log(0.25, 2, 3.0), Log(0.0, 3, 3.0))) == []


@pytest.mark.slow
def test_a_fit_of_the_constants_that_has_stuck_proves_nothing(tmp_path: Path) -> None:
    """Beside one whose mass is 0.3 % off, 0.1 N of friction look like a great gain; beside the better fit the hold-out hardly shows
    them."""
    state = opened(tmp_path, Log(0.1, 1), Log(0.1, 2, 4.0))
    model, theta = state.current.model, state.current.model.theta.copy()
    theta[[free.key for free in model.free].index("plant.joints.axis.mass")] *= 1.003
    done = fitted(state, model.with_theta(theta))
    stuck = replace(state, current=done, seen=tuple(evaluate(e, done.model, state.costs) for e in state.holdouts))
    assert stuck.cost > 2.0
    assert named(stuck) == []
    assert look_jointly(stuck, quiet).cost < 1.02


@pytest.mark.slow
def test_agreement_alone_is_not_enough(tmp_path: Path) -> None:
    """It takes too little of a hold-out of which a second log is noise that nothing explains."""
    state = opened(tmp_path, Log(0.2, 1), Log(0.2, 2, 3.0), Log(0.12, 3, 6.0, noise_um=3.2))
    assert named(state) == []


@pytest.mark.slow
@pytest.mark.parametrize(("noise_um", "found"), [(3.2, [("coulomb_friction", False)]), (4.0, [])], ids=["0.9 floors left", "1.8 left"])
def test_what_leaves_more_open_than_friction_of_another_form_is_no_explanation(
    tmp_path: Path, noise_um: float, found: list[tuple[str, bool]]
) -> None:
    """Of a gap of which it takes two thirds. As a cogging force: of 2.2e4 noise floors a sensor scale left a third."""
    assert named(opened(tmp_path, Log(0.5, 1), Log(0.5, 2, 3.0), Log(0.5, 3, 6.0, noise_um))) == found


@pytest.mark.slow
def test_what_takes_most_of_a_large_gap_explains_it(tmp_path: Path) -> None:
    """As pressure friction beside friction that slips otherwise than the model's: of 15.5 noise floors 2.7 were left."""
    state = opened(tmp_path, Log(2.0, 1), Log(2.0, 2, 3.0), Log(2.0, 3, 6.0, noise_um=4.0))
    found = look_jointly(state, quiet)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert state.cost > 50.0
    assert found.cost > 2.5


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


def test_with_caution_samples_count_for_less(state: GateSearch) -> None:
    plain = recounted(replace(state.costs, caution=1.0), state.current.evaluations)
    cautious = recounted(replace(state.costs, caution=CAUTION), state.current.evaluations)
    assert cautious.tau == pytest.approx(CAUTION * plain.tau)
    assert cautious.caution == CAUTION


def test_what_is_named_already_is_left_alone(state: GateSearch) -> None:
    assert look_jointly(state, quiet) is state


def test_where_no_effect_could_be_worth_anything_none_is_tried(state: GateSearch) -> None:
    """Its cost is at the floor: the model that has the friction."""
    assert look_jointly(replace(state, steps=()), quiet).steps == ()
