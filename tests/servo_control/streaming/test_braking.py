"""How fast a joint may be so that it still stops in time: against a joint that is braked cycle by cycle, and against √(2 a d)."""

from __future__ import annotations

from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from servo_control.streaming.braking import fastest

PERIODS = st.sampled_from([0.0005, 0.001, 0.01])
WAYS = st.floats(1e-9, 3.0)
ACCELERATIONS = st.floats(1e-2, 50.0)


def braked(rate: float, acceleration: float, period_s: float) -> float:
    """The way of a joint that goes one cycle at `rate`, then slows down by a T in every cycle."""
    way = 0.0
    while rate > 0.0:
        way += rate * period_s
        rate -= acceleration * period_s
    return way


@given(distance=WAYS, acceleration=ACCELERATIONS, period_s=PERIODS)
def test_a_joint_at_the_fastest_rate_stops_exactly_there(distance: float, acceleration: float, period_s: float) -> None:
    rate = fastest(distance, acceleration, period_s)
    assert braked(rate, acceleration, period_s) == pytest.approx(distance, rel=1e-6, abs=1e-12)
    assert braked(1.001 * rate, acceleration, period_s) > distance


@given(acceleration=ACCELERATIONS, period_s=PERIODS, pair=st.tuples(WAYS, WAYS))
def test_a_longer_way_never_asks_for_a_lower_rate(acceleration: float, period_s: float, pair: tuple[float, float]) -> None:
    shorter, longer = sorted(pair)
    assert fastest(shorter, acceleration, period_s) <= fastest(longer, acceleration, period_s) * (1.0 + 1e-12)


def test_on_a_long_way_it_is_the_usual_rule() -> None:
    assert fastest(2.0, 3.0, 1e-5) == pytest.approx(sqrt(2.0 * 3.0 * 2.0), rel=1e-4)


def test_without_way_there_is_no_rate() -> None:
    assert fastest(0.0, 1.0, 0.001) == fastest(-1.0, 1.0, 0.001) == 0.0
