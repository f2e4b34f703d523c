"""Constants that go back to the stated value: beside least squares with these held, by numpy."""

from __future__ import annotations

import numpy as np
import pytest

from gap.fitting.model import Free, Model
from gap.outcome.as_stated import as_stated
from tests.support.gap import axis_logs

NUMBERS, ROWS = 6, 40
EFFECT = 5  # the last number is an effect's size, which is no constant


def problem(seed: int) -> tuple[Model, np.ndarray, np.ndarray, np.ndarray]:
    """A linear one: model at its optimum, covariance, rows (logs and priors) and what they want."""
    draw = np.random.default_rng(seed)
    slopes = draw.normal(size=(ROWS, NUMBERS)) * 10.0 ** draw.uniform(-3, 2, NUMBERS)
    rows = np.concatenate([slopes, np.eye(NUMBERS)[:EFFECT]])  # a prior of standard deviation 1 about 0 for the constants
    wanted = np.concatenate([slopes @ draw.normal(size=NUMBERS) + draw.normal(size=ROWS), np.zeros(EFFECT)])
    theta = np.linalg.lstsq(rows, wanted)[0]
    free = tuple(Free((str(k),), f"k{k}", "", 0.0, 1.0, -50.0, 50.0, k != EFFECT, "A") for k in range(NUMBERS))
    return Model(axis_logs.axis_rig(), free, theta), np.linalg.inv(rows.T @ rows), rows, wanted


@pytest.mark.parametrize("seed", range(12))
def test_what_goes_back_costs_half_of_ln_p_at_most_and_the_others_follow(seed: int) -> None:
    model, covariance, rows, wanted = problem(seed)
    found = as_stated(model, covariance).theta
    back = found == 0.0
    rest = np.linalg.lstsq(rows[:, ~back], wanted)[0]
    assert found[~back] == pytest.approx(rest, rel=1e-6)
    cost = 0.5 * (np.sum((rows @ found - wanted) ** 2) - np.sum((rows @ model.theta - wanted) ** 2))
    assert cost <= 0.5 + 1e-9
    assert not back[EFFECT]


def test_most_problems_have_something_that_goes_back_and_something_that_does_not() -> None:
    counts = [int((as_stated(*problem(seed)[:2]).theta == 0.0).sum()) for seed in range(12)]
    assert sum(counts) > 12
    assert min(counts) < EFFECT


def test_a_constant_that_the_logs_moved_stays_moved() -> None:
    """3 standard deviations of the fit from the stated value, alone."""
    free = (Free(("a",), "a", "", 1.0, 0.1, 0.0, 10.0, True, "A"),)
    moved = Model(axis_logs.axis_rig(), free, np.array([1.03]))
    assert as_stated(moved, np.array([[1e-4]])).theta[0] == 1.03
    assert as_stated(moved, np.array([[1e-2]])).theta[0] == 1.0
