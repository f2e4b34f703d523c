"""Before nothing is named: constants that left their priors are no explanation where an effect does as well with all of them near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap.search.held_at_priors import look_held_at_priors
from gap.search.search_state import GateSearch
from gap.search.verdict import ALARM, alarmed
from tests.support.gap.finished_search import finished, quiet


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    """Friction that is missing in the rig file has been found."""
    return finished(tmp_path_factory.mktemp("held_at_priors"), size=1e-5)


def unnamed(done: GateSearch, pull: float) -> GateSearch:
    """The same search before it has found anything, its first constant so many prior standard deviations away."""
    model = done.nominal.model
    theta = model.theta + pull * model.scales * (np.arange(len(model.theta)) == 0)
    return replace(done, steps=(), current=replace(done.nominal, model=model.with_theta(theta)), seen=done.constants_only)


def test_the_effect_that_strained_constants_stood_for_is_named(done: GateSearch) -> None:
    state = unnamed(done, 1.1 * ALARM)
    found = look_held_at_priors(state, quiet)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert found.cost < 1.05
    assert alarmed(found.current) == []
    assert found.strained == ()  # these constants did not do as much
    assert found.constants_only is state.constants_only


def test_constants_that_do_as_much_are_told(done: GateSearch) -> None:
    """The verdict leaves the name tentative then."""
    state = replace(unnamed(done, 1.1 * ALARM), seen=done.seen)
    found = look_held_at_priors(state, quiet)
    assert [step.trial.candidate.effect for step in found.steps] == ["coulomb_friction"]
    assert found.strained == tuple(alarmed(state.current)) != ()


@pytest.mark.parametrize("why", ["named", "within its prior", "held before"])
def test_it_is_not_asked_for_nothing(done: GateSearch, why: str) -> None:
    state = {"named": done, "within its prior": unnamed(done, 0.0), "held before": replace(unnamed(done, 1.1 * ALARM), held=True)}[why]
    assert look_held_at_priors(state, quiet) is state
