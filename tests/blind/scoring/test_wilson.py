"""Wilson's interval against published values, and the power curve against one it was drawn from."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest

from tests.blind.scoring.wilson import half_power, wilson


@pytest.mark.parametrize(("hits", "trials"), [(0, 10), (1, 10), (15, 15), (52, 53), (81, 263), (148, 148), (0, 100)])
def test_interval_is_that_of_scipy(hits: int, trials: int) -> None:
    expected = binomtest(hits, trials).proportion_ci(method="wilson")
    assert wilson(hits, trials) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_published_values() -> None:
    """Newcombe, Statistics in Medicine 17 (1998), table I, method 3."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)


def test_nothing_is_known_without_trials() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


def test_half_power_finds_the_size_of_even_odds() -> None:
    draw = np.random.default_rng(3)
    sizes = np.repeat([0.3, 1.0, 3.0, 10.0], 200)
    named = draw.uniform(size=sizes.size) < 1 / (1 + np.exp(-2.0 * np.log(sizes / 1.7)))
    found = half_power(sizes.tolist(), named.tolist())
    assert found == pytest.approx(1.7, rel=0.15)


def test_half_power_says_nothing_of_what_is_always_named() -> None:
    assert half_power([1, 3, 10, 10], [True] * 4) is None
