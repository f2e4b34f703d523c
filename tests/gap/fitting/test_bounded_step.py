"""The largest of a convex quadratic in a box: its slope is 0 where nothing holds it and points outward at an end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gap.fitting.bounded_step import bounded
from gap.fitting.fit import _LEAST_DAMPING

Array = NDArray[np.float64]
CLOSE = 1e-6


def stands_at_the_largest(precision: Array, slope: Array, low: Array, high: Array, step: Array) -> bool:
    """The conditions of Karush, Kuhn and Tucker, in units of each number's own width."""
    width = np.sqrt(np.diag(np.linalg.inv(precision)))
    uphill = (slope - precision @ step) * width
    at_low, at_high = step <= low + CLOSE * width, step >= high - CLOSE * width
    inside = bool(np.all((step >= low - CLOSE) & (step <= high + CLOSE)))
    return (
        inside
        and bool(np.all(np.where(at_low, uphill <= CLOSE, True) & np.where(at_high, uphill >= -CLOSE, True)))
        and bool(np.all(np.abs(uphill[~at_low & ~at_high]) <= CLOSE))
    )


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 12), spread=st.floats(0.0, 2.0), far=st.floats(0.1, 100.0))
@settings(max_examples=200, deadline=None)
def test_it_is_the_largest_in_the_box(seed: int, count: int, spread: float, far: float) -> None:
    draw = np.random.default_rng(seed)
    lines = draw.normal(size=(count, count + 2)) * 10.0 ** draw.uniform(-spread, spread, (count, 1))
    precision = lines @ lines.T + np.eye(count)
    slope = precision @ draw.normal(size=count) * far
    low, high = -draw.uniform(0.0, 3.0, count) - 1e-3, draw.uniform(0.0, 3.0, count) + 1e-3
    assert stands_at_the_largest(precision, slope, low, high, bounded(precision, slope, low, high))


def test_one_number_at_its_end_does_not_drive_the_others_to_theirs() -> None:
    """Held at 0, the first number sends the second beyond its end at 4, and held there that one would send the third away; yet nothing is
    gained by going: solved one after the other the value was below that of no step."""
    columns = np.array([[1.0, 0.0, 0.0], [0.99, 0.1, 0.0], [0.98, 0.15, 0.1]])
    precision = 100.0 * columns @ columns.T + np.eye(3)
    slope = precision @ np.array([-30.0, 20.0, 5.0])
    low, high = np.array([0.0, -4.0, -4.0]), np.array([8.0, 4.0, 4.0])
    step = bounded(precision, slope, low, high)
    assert stands_at_the_largest(precision, slope, low, high, step)
    assert slope @ step - 0.5 * step @ precision @ step >= 0.0


def test_a_free_maximum_is_that_of_the_normal_equations() -> None:
    precision, slope = np.array([[4.0, 1.0], [1.0, 3.0]]), np.array([1.0, 2.0])
    assert bounded(precision, slope, np.full(2, -1.0), np.full(2, 1.0)) == pytest.approx([1.0 / 11.0, 7.0 / 11.0])


def test_two_numbers_that_do_the_same_stand_with_the_least_damping() -> None:
    """Neither has a prior: the fit's own damping is all that tells them apart."""
    both = np.array([1e5, 1.1e5])
    precision = np.outer(both, both) + np.diag(_LEAST_DAMPING * both**2)
    step = bounded(precision, precision @ np.array([2.0, 2.0]), np.full(2, -1.0), np.full(2, 1.0))
    assert step == pytest.approx([1.0, 1.0])
