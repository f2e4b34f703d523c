"""Weighted least squares with a between-log variance: closed forms, and how often the intervals hold the truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import linregress
from scipy.stats import t as student

from gap.watch.regression import Regression, regression

DAYS = np.linspace(0.0, 28.0, 15)
LINE = np.stack([np.ones(15), DAYS], axis=1)


def test_equal_logs_that_scatter_are_ordinary_least_squares() -> None:
    """With one standard deviation for all, far below the scatter, τ takes the whole of it: slope and interval are the textbook's."""
    values = 5.0 + 0.3 * DAYS + np.random.default_rng(1).standard_normal(15)
    found, textbook = regression(LINE, values, np.full(15, 1e-3)), linregress(DAYS, values)
    assert found.beta == pytest.approx([textbook.intercept, textbook.slope])
    assert np.sqrt(found.covariance[1, 1]) == pytest.approx(textbook.stderr, rel=1e-5)
    assert found.p_of(1) == pytest.approx(textbook.pvalue, rel=1e-3)
    assert found.times_sd() == pytest.approx(student.ppf(0.975, 13))


def test_logs_within_their_own_intervals_have_no_scatter_of_their_own() -> None:
    sds = np.linspace(0.5, 2.0, 15)
    found = regression(LINE, 5.0 + 0.3 * DAYS, sds)
    normal = LINE.T @ np.diag(sds**-2) @ LINE
    assert found.between_sd == 0.0
    assert found.covariance == pytest.approx(np.linalg.inv(normal))
    assert found.beta == pytest.approx([5.0, 0.3])


def test_two_logs_by_hand() -> None:
    """(y1 − y2)² / (s1² + s2² + 2 τ²) = 1 where that is the expected square of one degree of freedom."""
    found = regression(np.ones((2, 1)), np.array([0.0, 10.0]), np.array([3.0, 4.0]))
    assert found.between_sd**2 == pytest.approx((100 - 25) / 2)


def test_scatter_about_a_constant_makes_the_squares_left_three_of_four_logs() -> None:
    values, sds = np.array([1.0, 1.3, 0.7, 1.9]), np.array([0.2, 0.1, 0.3, 0.25])
    found = regression(np.ones((4, 1)), values, sds)
    variances = sds**2 + found.between_sd**2
    mean = np.average(values, weights=1.0 / variances)
    assert found.between_sd > 0.0
    assert found.beta == pytest.approx([mean])
    assert np.sum((values - mean) ** 2 / variances) == pytest.approx(3.0)


@pytest.mark.parametrize(("between", "most"), [(0.0, 0.995), (0.4, 0.975), (2.0, 0.975)])
def test_intervals_hold_the_truth_at_the_right_rate(between: float, most: float) -> None:
    """600 series of 12 logs of different accuracy: 95 % within binomial error; more where the logs' own intervals are all there is, since
    τ is never below 0."""
    draw = np.random.default_rng(7)
    held = 0
    for _ in range(600):
        sds = draw.uniform(0.2, 1.0, 12)
        days = np.sort(draw.uniform(0.0, 60.0, 12))
        values = 3.0 - 0.05 * days + np.hypot(sds, between) * draw.standard_normal(12)
        found = regression(np.stack([np.ones(12), days], axis=1), values, sds)
        held += abs(found.beta[1] + 0.05) < found.times_sd() * np.sqrt(found.covariance[1, 1])
    assert 0.925 < held / 600 < most


def test_two_logs_leave_nothing_to_tell_a_trend_by() -> None:
    found: Regression = regression(LINE[:2], np.array([1.0, 2.0]), np.ones(2))
    assert (found.times_sd(), found.p_of(1)) == (np.inf, 1.0)
