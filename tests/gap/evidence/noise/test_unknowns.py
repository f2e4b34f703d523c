"""What windows' own unknowns do is kept by fewer mixtures of them."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from gap.evidence.noise.unknowns import UNTOLD, told


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 9), st.integers(0, 4))
def test_mixtures_leave_the_covariance_as_it_is_within_what_the_noise_hides(seed: int, numbers: int, hardly: int) -> None:
    draw = np.random.default_rng(seed)
    a = draw.normal(size=(3, 40, numbers)) * 10.0 ** draw.uniform(-4.0, 2.0, size=(3, 1, numbers))
    a = np.concatenate([a, 1e-5 * draw.normal(size=(3, 40, hardly))], axis=2)
    a[:, 7] = 0.0  # a reading that is not there
    found = told(a)
    assert found.shape[2] <= numbers
    assert not found[:, 7].any()
    for before, after in zip(a, found, strict=True):
        assert np.linalg.norm(before @ before.T - after @ after.T, 2) <= UNTOLD**2 + 1e-10 * np.linalg.norm(before, 2) ** 2


def test_a_simulation_that_has_run_away_leaves_all_as_they_are() -> None:
    a = np.ones((2, 5, 3))
    a[1, 2, 0] = np.finfo(np.float64).max
    assert told(a) is a
