"""The plant's clock: one period a SYNC whatever the jitter, and the wall clock when SYNC stays away."""

from __future__ import annotations

import random

from sim_backend.twin.step_clock import LONGEST_CATCH_UP_PERIODS, TOLERATED_PERIODS, StepClock

MS = 1_000_000


def test_one_period_a_sync_under_jitter_of_two_periods() -> None:
    clock, generator = StepClock(1e-3), random.Random(3)
    steps = [clock.at_sync(1000 * MS + number * MS + generator.randrange(2 * MS)) for number in range(5000)]
    assert set(steps) == {1}


def test_syncs_faster_than_the_rate_take_the_plant_with_them() -> None:
    clock = StepClock(1e-3)
    assert sum(clock.at_sync(number * 1000) for number in range(3000)) == 3000
    assert clock.between(3 * MS + TOLERATED_PERIODS * MS) >= 1  # and no debt is left from the hurry


def test_without_sync_the_wall_clock_moves_the_plant() -> None:
    clock = StepClock(1e-3)
    moved = sum(clock.between(number * MS // 2) for number in range(2001))
    assert 1000 - TOLERATED_PERIODS <= moved <= 1000


def test_skipped_cycles_are_caught_up() -> None:
    clock = StepClock(1e-3)
    for number in range(100):
        clock.at_sync(number * MS)
    assert clock.at_sync(149 * MS) >= 49


def test_a_stopped_process_does_not_run_for_ever() -> None:
    clock = StepClock(1e-3)
    clock.at_sync(0)
    assert clock.between(3600 * 1000 * MS) == LONGEST_CATCH_UP_PERIODS
    assert clock.between(3600 * 1000 * MS + MS) == 0
