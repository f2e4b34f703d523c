"""What one log says of a number by itself: against the closed forms of a linear model with normal noise."""

from __future__ import annotations

import numpy as np
import pytest

from gap.watch.log_fit import alone

DRAW = np.random.default_rng(3)
SIGNATURES = DRAW.standard_normal((40, 4)) * np.array([3.0, 1.0, 0.5, 0.02])  # the last one is hardly seen
SIGNATURES[:, 1] += 0.8 * SIGNATURES[:, 0]
C = np.linalg.inv(SIGNATURES.T @ SIGNATURES + np.eye(4))


def posterior_mean(y: np.ndarray) -> np.ndarray:
    return C @ (SIGNATURES.T @ y)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_a_number_is_what_least_squares_says_with_the_priors_of_the_others_alone(number: int) -> None:
    """y = x φ + noise, the others' priors part of the noise: V = 1 + X X'."""
    y = DRAW.standard_normal(40) + SIGNATURES @ np.array([2.0, -1.0, 0.5, 0.1])
    x, others = SIGNATURES[:, number], np.delete(SIGNATURES, number, axis=1)
    weight = np.linalg.inv(np.eye(40) + others @ others.T) @ x
    values, sds, _ = alone(C, posterior_mean(y), np.zeros(4))
    assert values[number] == pytest.approx(weight @ y / (weight @ x))
    assert sds[number] == pytest.approx((weight @ x) ** -0.5)


def test_a_repeat_differs_by_its_noise_and_not_by_what_is_wrong_in_all_logs() -> None:
    truth = SIGNATURES @ np.array([1.0, 2.0, -1.0, 3.0])
    found = np.array([alone(C, posterior_mean(truth + DRAW.standard_normal(40)), np.zeros(4))[0] for _ in range(2000)])
    _, sds, again = alone(C, np.zeros(4), np.zeros(4))
    assert found[:, :3].std(axis=0) == pytest.approx(again[:3], rel=0.06)
    assert np.all(again[:3] <= sds[:3])


def test_what_is_hardly_seen_is_not_told_and_votes_widen() -> None:
    _, sds, again = alone(C, np.zeros(4), np.array([1.0, 0.0, 0.0, 0.0]))
    assert np.isinf(sds[3])
    assert sds[0] == again[0] >= 1.0
