"""How much logs count for: nothing is lost of short logs nor where friction has the model's form, and faults that repeat never add up to
certainty."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import expon, norm

from gap.evidence.deciding_numbers import COUNT
from gap.evidence.score.coarsening import distance, power


def test_a_short_log_counts_in_full_and_a_long_one_for_a_limited_number_of_windows() -> None:
    windows = [1, 2, 5, 40, 1000, 10**9]
    counted = [n * power(n, 1.0) for n in windows]
    assert power(0, 1.0) == 1.0
    assert counted == sorted(counted)
    assert counted[-1] == pytest.approx(COUNT, rel=1e-5)
    assert counted[0] > 0.6


def test_friction_of_the_models_own_form_lets_every_window_count() -> None:
    counted = [40 * power(40, form) for form in (0.0, 1e-5, 0.1, 0.3, 1.0)]
    assert counted == sorted(counted, reverse=True)
    assert counted[0] == 40.0
    assert counted[1] > 39.99


def test_what_acts_unexplained_repeats_in_every_window() -> None:
    """Where all of the discrepancy is more than honest models leave, logs count for COUNT windows, whatever the friction's form."""
    counted = [1000 * power(1000, 0.0, excess) for excess in (0.0, 1e-3, 0.1, 0.9, 1.0)]
    assert counted == sorted(counted, reverse=True)
    assert counted[0] == 1000.0
    assert counted[-1] == pytest.approx(COUNT, rel=3e-3)
    assert power(1000, 0.5, 1.0) == power(1000, 0.0, 1.0)
    assert power(40, 0.5, 0.3) < min(power(40, 0.5), power(40, 0.0, 0.3))


def test_it_is_the_posterior_of_models_that_may_be_a_distance_away() -> None:
    """Miller and Dunson 2019, sec. 2.3: given that the logs' distribution lies within R of the model's, R exponential with that mean, the
    mean of normal data is as wide as with the power ζ."""
    n, form = 40, 0.5
    mean_of_data = norm(0.0, 1.0 / np.sqrt(n))

    def likely(mean: float) -> float:
        """P(distance of the data's mean from the model's < R), over the data's own scatter."""
        return quad(lambda m: mean_of_data.pdf(m) * expon.sf(0.5 * (m - mean) ** 2, scale=distance(form)), -4.0, 4.0, points=[0.0])[0]

    widths = np.linspace(0.1, 0.8, 8)
    exact = np.log([likely(m) / likely(0.0) for m in widths])
    assert exact == pytest.approx(-0.5 * power(n, form) * n * widths**2, rel=1e-3)
