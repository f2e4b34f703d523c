"""How many windows must agree before a candidate is named, and how much it must take."""

from __future__ import annotations

import pytest
from scipy.stats import norm

from gap.search.select import FALSE_ALARM, least_t, passes


@pytest.mark.parametrize(
    ("t", "gain", "clear"),
    [(3.7, 0.15, False), (3.9, 0.15, True), (2.4, 0.5, False), (2.6, 0.5, True), (3.2, 0.325, True), (2.1, 0.97, True), (1.9, 0.97, False)],
    ids=["few", "enough", "few, but half of the gap", "enough for half", "between", "few, but all of the gap", "hardly any"],
)
def test_the_more_of_the_gap_a_candidate_takes_the_fewer_windows_it_needs(t: float, gain: float, clear: bool) -> None:
    assert passes(t, gain, drop=0.4, least=3.8) is clear


def test_half_of_what_stays_far_open_is_no_explanation() -> None:
    """A cogging force: 2.2e4 noise floors, of which an inertia took 69 % with t below 3.8."""
    assert not passes(3.0, 0.69, drop=1.5e4, least=3.8)
    assert passes(3.9, 0.69, drop=1.5e4, least=3.8)


def test_half_of_next_to_nothing_is_no_half() -> None:
    """As on an effect-free log: 1.053 noise floors, of which an offset took 42 % with t = 3.0."""
    assert not passes(3.0, 0.42, drop=0.022, least=3.8)
    assert passes(3.0, 0.42, drop=0.3, least=3.8)


@pytest.mark.parametrize(("gain", "drop"), [(0.1, 1.0), (0.5, 0.01)], ids=["a small share", "next to nothing"])
def test_agreement_alone_is_not_enough(gain: float, drop: float) -> None:
    assert not passes(20.0, gain, drop, least=3.8)


def test_more_candidates_need_more_agreement() -> None:
    assert least_t(1) == 3.5
    assert least_t(200) > least_t(60) > 3.5
    assert 3 * 200 * norm.sf(least_t(200)) == pytest.approx(FALSE_ALARM)  # of 200 candidates in three stages
