"""The instrument of the fault matrix against registers whose history is known."""

from __future__ import annotations

import pytest

from daemon.faults.benches.register_watch import RegisterWatch
from daemon.faults.fault import NEVER_MS
from drivers.output_register import OutputRegister

MS = 1_000_000


def test_a_register_that_nobody_writes_is_safe_after_its_time_out_however_seldom_one_looks() -> None:
    register = OutputRegister.create((0.0, 0.0), 0.1)
    register.write((1.0, 2.0), 5 * MS)
    watch = RegisterWatch(register, 7 * MS)
    for now_ms in (8, 60, 130):
        watch.update(now_ms * MS)
    assert watch.safe_after_ms == pytest.approx(98.0)
    assert watch.timed_out
    assert watch.safe_for_ms(130 * MS) == pytest.approx(25.0)


def test_a_write_and_its_time_out_between_two_looks_count_from_the_write() -> None:
    """Who looks may be kept off the processor for longer than the time-out."""
    register = OutputRegister.create((0.0,), 0.1)
    watch = RegisterWatch(register, 0)
    register.write((1.0,), 1 * MS)
    watch.update(2 * MS)
    register.write((1.5,), 8 * MS)
    watch.update(190 * MS)
    assert watch.safe_after_ms == pytest.approx(108.0)
    assert watch.timed_out


def test_a_safe_write_counts_from_the_look_that_found_it() -> None:
    register = OutputRegister.create((0.0,), 0.1)
    register.write((1.0,), 0)
    watch = RegisterWatch(register, 0)
    watch.update(1 * MS)
    register.make_safe()
    watch.update(3 * MS)
    assert watch.safe_after_ms == pytest.approx(3.0)
    assert not watch.timed_out


def test_outputs_that_act_again_were_not_safe() -> None:
    register = OutputRegister.create((0.0,), 0.1)
    watch = RegisterWatch(register, 0)
    watch.update(0)
    register.write((1.0,), 2 * MS)
    watch.update(3 * MS)
    assert watch.safe_after_ms == NEVER_MS


def test_the_longest_pause_is_that_between_two_renewals() -> None:
    register = OutputRegister.create((0.0,), 0.1)
    watch = RegisterWatch(register, 0)
    for now_ms in (1, 2, 25, 26):
        register.write((1.0,), now_ms * MS)
        watch.update(now_ms * MS)
    assert watch.longest_pause_ms == pytest.approx(23.0)


def test_rest_ends_with_every_command_that_moves() -> None:
    register = OutputRegister.create((0.0, 0.0), 0.1)
    watch = RegisterWatch(register, 0)
    for now_ms, volts in ((1, 0.01), (2, -3.0), (3, 0.02), (9, -0.02)):
        register.write((volts, 0.0), now_ms * MS)
        watch.update(now_ms * MS)
    assert watch.rest_after_ms == pytest.approx(3.0)
    assert watch.rest_for_ms(9 * MS) == pytest.approx(6.0)
