"""Shares of sets against closed forms: windows that agree, a gain that rests on one window, what all sets share."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import expit
from scipy.stats import beta

from gap.evidence.score.bootstrap import Weight, bootstrapped

WINDOWS = 40


def test_windows_that_agree_leave_the_shares_of_the_evidence() -> None:
    spread = np.random.default_rng(3).normal(size=WINDOWS)
    sets = [Weight(mass, spread + mass / WINDOWS) for mass in (0.0, 2.0, -1.0)]
    expected = np.exp([0.0, 2.0, -1.0]) / np.exp([0.0, 2.0, -1.0]).sum()
    assert bootstrapped(sets) == pytest.approx(expected, abs=1e-9)


def test_a_gain_of_one_window_is_believed_as_often_as_that_window_weighs_enough() -> None:
    """Its weight is WINDOWS times a number of the distribution Beta(1, WINDOWS - 1), the marginal of Dirichlet(1, …, 1)."""
    gain, odds = 14.0, -4.0  # of one window, and of the prior
    one = np.zeros(WINDOWS)
    one[7] = gain
    of_weight = beta(1, WINDOWS - 1)
    expected, _ = quad(lambda w: of_weight.pdf(w) * expit(odds + gain * WINDOWS * w), 0.0, 1.0, limit=400, points=[0.005, 0.01, 0.05])
    without, with_it = bootstrapped([Weight(0.0, np.zeros(WINDOWS)), Weight(odds + gain, one)])
    assert with_it == pytest.approx(expected, abs=0.02)
    assert with_it < 0.8 < expit(odds + gain)  # the sum of all windows would be sure
    assert with_it + without == pytest.approx(1.0)


def test_the_same_gain_of_all_windows_alike_is_sure() -> None:
    shares = bootstrapped([Weight(0.0, np.zeros(WINDOWS)), Weight(10.0, np.full(WINDOWS, 14.0 / WINDOWS))])
    assert shares[1] == pytest.approx(expit(10.0), abs=1e-6)


def test_what_all_sets_share_changes_nothing() -> None:
    draw = np.random.default_rng(5)
    windows, shared = draw.normal(size=(3, WINDOWS)), 1e4 * draw.normal(size=WINDOWS)
    sets = [Weight(mass, own) for mass, own in zip((0.0, 1.0, 3.0), windows, strict=True)]
    moved = [Weight(s.log_mass + shared.sum(), s.windows + shared) for s in sets]
    assert bootstrapped(moved) == pytest.approx(bootstrapped(sets), abs=1e-6)
