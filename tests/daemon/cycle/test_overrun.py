from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema.rig import Overruns
from daemon.cycle.overrun import PHASES, OverrunPolicy, slowest_phase

MS = 1_000_000
IN_TIME = [0] * len(PHASES)


def phases(**lengths: int) -> list[int]:
    return [lengths.get(phase, 1000) for phase in PHASES]


def test_in_time_the_next_deadline_is_one_period_later() -> None:
    policy = OverrunPolicy(MS, Overruns())
    assert policy.next_deadline(10 * MS, 10 * MS + 400_000, IN_TIME) == 11 * MS
    assert (policy.overruns, policy.missed_periods, policy.late_ns) == (0, 0, 0)


@pytest.mark.parametrize(
    ("delay_ms", "missed", "culprit"),
    [(1.5, 0, "read"), (5, 4, "compute"), (20, 19, "write"), (100, 99, "wait")],
)
def test_late_cycles_skip_whole_periods_and_keep_phase(delay_ms: float, missed: int, culprit: str) -> None:
    """The cycle of deadline 0 takes delay_ms: `missed` deadlines are skipped, the next lies less than a period before its end."""
    policy = OverrunPolicy(MS, Overruns())
    end = round(delay_ms * MS)
    following = policy.next_deadline(0, end, phases(**{culprit: end}))
    assert following % MS == 0
    assert following <= end < following + MS
    assert policy.missed == policy.missed_periods == missed
    assert policy.late_ns == end - MS
    assert policy.culprit == culprit
    assert policy.by_culprit[culprit] == policy.overruns == 1


@given(st.lists(st.integers(0, 120 * MS), min_size=1, max_size=100))
def test_executed_and_missed_periods_account_for_all_time(lengths: list[int]) -> None:
    policy = OverrunPolicy(MS, Overruns())
    deadline, end = 0, 0
    for length in lengths:
        end = max(deadline, end) + length
        deadline = policy.next_deadline(deadline, end, IN_TIME)
        assert deadline % MS == 0
        assert end < deadline + MS, "a cycle begins less than a period late"
    assert deadline == MS * (len(lengths) + policy.missed_periods)


def test_window_forgets_and_counts_no_further_than_needed() -> None:
    policy = OverrunPolicy(MS, Overruns(window=1.0, stop_after=5))
    for number in range(4):
        policy.next_deadline(0, (10 + number) * MS, IN_TIME)
    assert policy.in_window(20 * MS) == 4
    assert policy.in_window(1012 * MS) == 2
    for number in range(50):
        policy.next_deadline(0, (2000 + number) * MS, IN_TIME)
    assert policy.in_window(2050 * MS) == 6


def test_a_long_activation_is_no_overrun_and_keeps_phase() -> None:
    policy = OverrunPolicy(MS, Overruns())
    assert policy.deadline_after_activation(0, 300_000) == MS
    assert policy.deadline_after_activation(0, 80 * MS + 1) == 81 * MS
    assert policy.deadline_after_activation(0, 80 * MS) == 80 * MS
    assert (policy.overruns, policy.missed_periods, policy.late_ns, policy.in_window(81 * MS)) == (0, 0, 0, 0)


def test_slowest_phase_by_name() -> None:
    for phase in PHASES:
        assert slowest_phase(phases(**{phase: 5000})) == phase
