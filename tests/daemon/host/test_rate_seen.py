"""What is said of a rate, against columns whose figures are known beforehand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from config.loading.load import apply_overrides, load_rig, rig_from_text
from config.schema.rig import Loop
from daemon.host.rate_seen import RateSeen, rate_seen

RATE_HZ = 1000.0


def columns(cycles: int = 2000, **given: Any) -> dict[str, Any]:
    """A loop that was never late and worked 60 us a cycle."""
    cycle = np.arange(cycles)
    work = {name: np.full(cycles, 20.0) for name in ("read_us", "compute_us", "write_us")}
    return {"cycle": cycle + 7, "t_s": cycle / RATE_HZ, "late_us": np.zeros(cycles), "overruns": np.zeros(cycles, int), **work, **given}


def seen(loop: Loop | None = None, **given: Any) -> RateSeen:
    return rate_seen(columns(**given), loop or Loop(), RATE_HZ, True, ())


def windowed(length: str) -> Loop:
    return rig_from_text(apply_overrides(load_rig("ornl_testbed").text, [f"loop.overruns.window={length}"])).loop


def test_a_loop_in_time_keeps_the_rate() -> None:
    found = seen()
    assert (found.cycles, found.overruns, found.in_window, found.lost, found.largest_s) == (2000, 0, 0, 0, pytest.approx(0.0, abs=1e-9))
    assert found.work_p99_s == pytest.approx(60e-6)
    assert found.keeps_rate


def test_a_cycle_that_ended_late_is_known_by_the_periods_it_skipped_and_by_how_late_the_next_began() -> None:
    t_s = np.arange(2000) / RATE_HZ
    t_s[1000:] += 3 / RATE_HZ
    late_us = np.zeros(2000)
    late_us[1000] = 400.0
    assert seen(t_s=t_s, late_us=late_us, overruns=np.repeat([0, 1], 1000)).largest_s == pytest.approx(3.4e-3)


def test_overruns_are_counted_within_the_rigs_window() -> None:
    """Six early on and eight a second and a half later; of a window of 1 s only one of the groups lies in it."""
    counted = np.zeros(2000, int)
    counted[[10, 12, 14, 16, 18, 20]] += 1
    counted[1500:1516:2] += 1
    found = seen(overruns=np.cumsum(counted))
    assert (found.overruns, found.in_window) == (14, 8)
    assert found.keeps_rate
    whole = seen(windowed("2 s"), overruns=np.cumsum(counted))
    assert whole.in_window == 14
    assert not whole.keeps_rate


def test_a_window_longer_than_what_was_seen_holds_as_many_more() -> None:
    counted = np.cumsum(np.isin(np.arange(2000), [400, 900, 1400]))
    assert seen(windowed("4 s"), overruns=counted).keeps_rate
    assert not seen(windowed("10 s"), overruns=counted).keeps_rate  # 15 expected of 10 that are allowed


def test_half_of_what_the_rig_allows_is_too_much() -> None:
    good = seen()
    assert replace(good, in_window=9).keeps_rate
    assert not replace(good, in_window=10).keeps_rate
    assert not replace(good, largest_s=0.03).keeps_rate


def test_a_log_with_a_hole_keeps_no_rate() -> None:
    kept = np.r_[0:500, 510:2000]
    whole = columns()
    found = rate_seen({name: values[kept] for name, values in whole.items()}, Loop(), RATE_HZ, True, ())
    assert found.lost == 10
    assert not found.keeps_rate
    assert "10 cycles are absent from the log" in found.text()
