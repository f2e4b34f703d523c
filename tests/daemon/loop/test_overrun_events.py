"""Overruns are counted all, and told a few times a second: a loop that is always late must not fill the log with it."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from tests.support.daemon.rigs import delay_once, simple_rig


def test_a_loop_that_is_always_late_says_so_five_times_a_second(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(10)
        device.on_read = lambda: delay_once(rig, 1_500_000)  # every second period is missed
        before_s = rig.value("t_s")
        rig.cycles(1500)
        device.on_read = lambda: None
        rig.cycles(1)
        elapsed_s = rig.value("t_s") - before_s
        told = [event for event in rig.events if event.name == "overrun"]
        assert rig.value("overruns") == 1500
        assert len(told) == round(5 * elapsed_s)
        assert all(later.t_s - earlier.t_s >= 0.2 - 1e-9 for earlier, later in pairwise(told))
        assert told[-1].values["overruns"] > told[0].values["overruns"], "what was not told is in the count of the next"
