"""The plant's clock: one period a SYNC whatever the jitter, and the wall clock when SYNC stays away."""

from __future__ import annotations

import random

from sim_backend.twin.step_clock import LONGEST_CATCH_UP_PERIODS, TOLERATED_S, StepClock

MS = 1_000_000
TOLERATED_MS = round(1e3 * TOLERATED_S)


def test_one_period_a_sync_under_jitter_and_stalls_shorter_than_tolerated() -> None:
    clock, generator = StepClock(1e-3), random.Random(3)
    now_ns, steps = 1000 * MS, []
    for _ in range(5000):
        now_ns += generator.choice((MS // 2, MS, 2 * MS, (TOLERATED_MS - 1) * MS))
        assert clock.between(now_ns - 1000) == 0
        steps.append(clock.at_sync(now_ns))
    assert set(steps) == {1}
    assert clock.caught_up == 0


def test_syncs_faster_than_the_rate_take_the_plant_with_them() -> None:
    clock = StepClock(1e-3)
    assert sum(clock.at_sync(number * 1000) for number in range(3000)) == 3000
    assert clock.between(3 * MS + (TOLERATED_MS + 1) * MS) >= 1  # and no debt is left from the hurry


def test_without_sync_the_wall_clock_moves_the_plant_in_single_periods() -> None:
    clock = StepClock(1e-3)
    moved = [clock.between(number * MS // 2) for number in range(2001)]
    assert sum(moved) == 1000
    first = moved.index(TOLERATED_MS)  # what the silence has cost, at once
    assert max(moved[first + 1 :]) == 1


def test_after_a_long_silence_the_skipped_cycles_are_caught_up() -> None:
    clock = StepClock(1e-3)
    for number in range(100):
        clock.at_sync(number * MS)
    assert clock.at_sync(149 * MS) == 50
    assert clock.at_sync(150 * MS) == 1


def test_cycles_that_were_made_while_the_twin_stood_still_are_not_moved_twice() -> None:
    """They arrived one by one, and it is the times of arrival that are handed in."""
    clock = StepClock(1e-3)
    clock.at_sync(0)
    assert [clock.at_sync(number * MS) for number in range(1, 200)] == [1] * 199
    assert clock.between(200 * MS) == 0


def test_a_stopped_process_does_not_run_for_ever() -> None:
    clock = StepClock(1e-3)
    clock.at_sync(0)
    assert clock.between(3600 * 1000 * MS) == LONGEST_CATCH_UP_PERIODS
    assert clock.between(3600 * 1000 * MS + MS - 1) == 0
