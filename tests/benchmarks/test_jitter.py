"""The figures of the jitter benchmark: periods from the begins of cycles, missed periods, the interval of a median, the table."""

from __future__ import annotations

import pytest

from benchmarks.loop.jitter_table import interval_of_median, interval_of_sum, table
from benchmarks.loop.periods import began_of_lateness, figures

PERIOD_US = 1000.0


def test_a_loop_in_time_has_no_jitter_and_misses_nothing() -> None:
    found = figures([PERIOD_US * cycle for cycle in range(101)], PERIOD_US)
    assert (found["p50"], found["p99.9"], found["missed"], found["cycles"]) == (0.0, 0.0, 0.0, 101)


@pytest.mark.parametrize(("late_us", "missed"), [(900.0, 0.0), (1200.0, 1.0), (5300.0, 5.0)])
def test_missed_periods_are_the_same_for_a_loop_that_skips_and_one_that_catches_up(late_us: float, missed: float) -> None:
    skipping = began_of_lateness([0.0] * 10 + [late_us] + [0.0] * 10, PERIOD_US)
    catching_up, now = [], 0.0
    for cycle in range(21):
        now = max(now + 10.0, PERIOD_US * cycle + (late_us if cycle == 10 else 0.0))
        catching_up.append(now)
    assert figures(skipping, PERIOD_US)["missed"] == figures(catching_up, PERIOD_US)["missed"] == missed


def test_the_interval_holds_the_median_and_is_narrow_where_the_values_agree() -> None:
    low, high = interval_of_median([1.0] * 20 + [50.0])
    assert (low, high) == (1.0, 1.0)
    low, high = interval_of_median([0.1, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0])
    assert low < 1.0 < high


def test_what_one_turn_missed_is_not_known_to_be_missed_again() -> None:
    assert interval_of_sum([3.0] * 20) == (60.0, 60.0)
    low, high = interval_of_sum([0.0] * 20 + [70.0])  # it is in a sample with the probability 1 − (20/21)²¹ = 0.64
    assert low == 0.0
    assert high >= 140.0


def test_the_table_counts_turns_runs_that_broke_off_and_ratios_above_the_limit() -> None:
    own, rival = figures([0.0, 1000.0, 2100.0], PERIOD_US), figures([0.0, 1000.0, 2010.0], PERIOD_US)
    turn = {"utc": "2026-11-24 08:00:00", "load": "idle", "wanted_1_min": 1.0, "busy_beside": 0.5, "runs": {}, "broken": {}}
    turns = [{**turn, "runs": {"clock": own, "cyclictest": rival}, "broken": {"longreachd": "fault"}}, {**turn, "load": "1"}]
    text = "\n".join(table(turns))
    assert "no load of its own, 1 turns" in text
    assert "load on processor 1, 1 turns" in text
    assert "clock over cyclictest" in text
    assert "1 of 1" in text
    assert "missed more" in text
    assert "LinuxCNC" not in text
