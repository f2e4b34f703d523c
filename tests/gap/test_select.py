"""How many windows must agree before a candidate is named, and how much it must take."""

from __future__ import annotations

import pytest
from scipy.stats import norm

from gap.search.select import FALSE_ALARM, least_t, passes


@pytest.mark.parametrize(
    ("t", "gain", "clear"),
    [(3.4, 0.5, False), (3.9, 0.5, True), (2.5, 0.97, True), (1.9, 0.97, False), (2.5, 0.89, False)],
    ids=["few windows", "enough windows", "few, but all of the gap", "hardly any", "few, and not all of it"],
)
def test_a_candidate_that_closes_the_gap_needs_fewer_windows(t: float, gain: float, clear: bool) -> None:
    assert passes(t, gain, drop=1.0, least=3.8) is clear


@pytest.mark.parametrize(("gain", "drop"), [(0.1, 1.0), (0.5, 0.01)], ids=["a small share", "next to nothing"])
def test_agreement_alone_is_not_enough(gain: float, drop: float) -> None:
    assert not passes(20.0, gain, drop, least=3.8)


def test_more_candidates_need_more_agreement() -> None:
    assert least_t(1) == 3.5
    assert least_t(200) > least_t(60) > 3.5
    assert 3 * 200 * norm.sf(least_t(200)) == pytest.approx(FALSE_ALARM)  # of 200 candidates in three stages
