from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from daemon.cycle.clock import AdaptiveSpin, LockstepClock, WallClock
from daemon.cycle.timing import EDGES_US, QUANTITIES, WORDS, Timing, grade, passport


@given(st.lists(st.floats(0.0, 2e6), min_size=1, max_size=300), st.sampled_from([50.0, 90.0, 99.0, 100.0]))
def test_a_percentile_lies_within_one_bin_of_the_exact_one(values: list[float], percent: float) -> None:
    timing = Timing([0] * WORDS)
    for value in values:
        timing.count(1, value)
    exact = float(np.percentile(values, percent, method="inverted_cdf"))
    edge = min((edge for edge in EDGES_US if edge >= exact), default=max(values))
    below = max((edge for edge in EDGES_US if edge < exact), default=0.0)
    assert below - 1e-3 <= timing.percentile_us("read", percent) <= edge
    assert sum(timing.counts("read")) == len(values)
    assert timing.largest_us("read") == pytest.approx(max(values), abs=1e-3)
    assert sum(timing.counts("late")) == 0


def test_shared_memory_serves_as_well_as_a_list() -> None:
    from daemon.ipc.shared_memory import SharedMemory

    shared = SharedMemory.create("timing", 8 * WORDS)
    counting, looking = Timing(shared.words), Timing(SharedMemory(shared.descriptor).words)
    for value in (3.0, 30.0, 300.0):
        counting.count(0, value)
    assert looking.percentile_us("late", 50.0) == 30
    assert looking.largest_us("late") == pytest.approx(300.0)
    counting.clear()
    assert looking.largest_us("late") == 0.0


@pytest.mark.parametrize(
    ("late_us", "overruns", "expected"),
    [(50, 0, "A"), (50, 1, "A"), (51, 0, "B"), (50, 2, "B"), (200, 10, "B"), (201, 0, "C"), (10, 11, "C")],
)
def test_grade_of_ten_thousand_cycles_at_1_kHz(late_us: float, overruns: int, expected: str) -> None:
    assert grade(late_us, overruns, 10_000, 1000.0) == expected


def test_passport_names_the_culprits_and_holds_every_histogram() -> None:
    timing = Timing([0] * WORDS)
    for quantity in range(len(QUANTITIES)):
        timing.count(quantity, 10.0)
    entries = passport(timing, {"wait": 0, "read": 3, "compute": 1}, 7, 1000, 1000.0)
    assert entries["overruns"] == "4"
    assert entries["missed_periods"] == "7"
    assert entries["overrun_culprits"] == "read 3, compute 1"
    assert all(sum(map(int, entries[f"{quantity}_histogram"].split())) == 1 for quantity in QUANTITIES)


def test_the_wall_clock_is_never_early_and_does_not_wait_for_the_past() -> None:
    clock = WallClock(spin_s=1e-4, period_s=1e-3)
    for ahead_ns in (0, 50_000, 2_000_000):
        deadline = clock.now_ns() + ahead_ns
        assert clock.wait_until(deadline) >= deadline
    before = clock.now_ns()
    clock.wait_until(before - 10**9)
    assert clock.now_ns() - before < 10**8


def test_the_spin_covers_late_wake_ups_within_the_period_and_forgets_them() -> None:
    spin = AdaptiveSpin(150e3, 1e6)
    for late in (10e3, 50e3, 80e3):
        spin.woke(late)
    assert spin.ns == 150e3  # the least covers them
    spin.woke(200e3)
    assert spin.ns == 250e3
    spin.woke(5e6)
    assert spin.ns == pytest.approx(249.75e3)  # a pause of the machine: no spin would have covered it
    spin.woke(390e3)
    assert spin.ns == 400e3  # never more than 0.4 of the period
    cycles = 0
    while spin.ns > 150e3:
        spin.woke(60e3)
        cycles += 1
    assert 1100 < cycles < 1300  # 0.39 ms fade to 0.12 ms by a thousandth a cycle: ln(3.25) / 0.001
    assert AdaptiveSpin(0.0, 1e6).ns == 0.0
    never = AdaptiveSpin(0.0, 1e6)
    never.woke(5e6)
    assert never.ns == 0.0


def test_the_lockstep_clock_only_moves_by_waiting() -> None:
    clock = LockstepClock()
    assert clock.wait_until(5_000) == 5_000
    assert clock.wait_until(3_000) == clock.now_ns() == 5_000
