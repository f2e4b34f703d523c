"""Shares of sets against closed forms: windows that agree, a gain that rests on one window, what all sets share."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import expit
from scipy.stats import beta

from gap.evidence.deciding_numbers import NEGLIGIBLE
from gap.evidence.score.bootstrap import Weight, bootstrapped

WINDOWS = 40
LOST = np.exp(NEGLIGIBLE)  # probability of an event in a window that no model foretells


def test_windows_that_agree_leave_the_shares_of_the_evidence() -> None:
    spread = np.random.default_rng(3).normal(size=WINDOWS)
    sets = [Weight(mass, spread + mass / WINDOWS) for mass in (0.0, 2.0, -1.0)]
    below = np.array([2.0, 0.0, 3.0])  # of the best set, in all windows together: a little of it may be luck in each
    masses = WINDOWS * np.log((1.0 - LOST) * np.exp(-below / WINDOWS) + LOST)
    assert masses == pytest.approx(-below, rel=0.06)
    assert bootstrapped(sets) == pytest.approx(np.exp(masses) / np.exp(masses).sum(), abs=1e-9)


def test_a_gain_of_one_window_is_believed_as_often_as_that_window_weighs_enough() -> None:
    """Its weight is WINDOWS times a number of the distribution Beta(1, WINDOWS - 1), the marginal of Dirichlet(1, …, 1)."""
    gain, odds = 2.5, 1.0  # of one window, and of all others and the prior
    one = np.zeros(WINDOWS)
    one[7] = gain
    counted = -np.log((1.0 - LOST) * np.exp(-gain) + LOST)
    of_weight = beta(1, WINDOWS - 1)
    expected, _ = quad(lambda w: of_weight.pdf(w) * expit(odds + counted * WINDOWS * w), 0.0, 1.0, limit=400, points=[0.005, 0.01, 0.05])
    without, with_it = bootstrapped([Weight(0.0, np.zeros(WINDOWS)), Weight(odds + gain, one)])
    assert with_it == pytest.approx(expected, abs=0.01)
    assert with_it < expit(odds + gain)
    assert with_it + without == pytest.approx(1.0)


def test_what_one_window_says_makes_no_set_negligible() -> None:
    """A joint that let go a moment too early: 90 of ln p in one window of forty, and nothing in the others."""
    one = np.zeros(WINDOWS)
    one[7] = 90.0
    luck, other = bootstrapped([Weight(90.0, one), Weight(0.0, np.zeros(WINDOWS))])
    assert other > LOST
    assert luck > 0.5


def test_the_same_gain_of_all_windows_alike_is_sure() -> None:
    shares = bootstrapped([Weight(0.0, np.zeros(WINDOWS)), Weight(10.0, np.full(WINDOWS, 14.0 / WINDOWS))])
    assert 1.0 - shares[1] < 3.0 * expit(-10.0)


def test_what_all_sets_share_changes_nothing() -> None:
    draw = np.random.default_rng(5)
    windows, shared = draw.normal(size=(3, WINDOWS)), 1e4 * draw.normal(size=WINDOWS)
    sets = [Weight(mass, own) for mass, own in zip((0.0, 1.0, 3.0), windows, strict=True)]
    moved = [Weight(s.log_mass + shared.sum(), s.windows + shared) for s in sets]
    assert bootstrapped(moved) == pytest.approx(bootstrapped(sets), abs=1e-6)
