"""Keys pressed by a script on the simulated rig: shaped, the tip swings a fifth as much as unshaped, or less; and the log re-executes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.hand_driven import SCRIPTS, Script, driven, strokes, swing
from recording.evaluation.replay import reexecute
from recording.files.reader import Log, read_log
from servo_control.signals import Mode, Wanted


def slows_down_after(log: Log, heard_s: float) -> float:
    """From the last that was heard of a key to the first cycle in which a joint's target is slower than its fastest after that."""
    rows = log.columns["mode"] == Mode.RUNNING
    t = log.columns["t_s"][rows] - log.columns["t_s"][rows][0]
    rates = np.abs(np.column_stack([log.columns[f"{joint}.target_rate"][rows] for joint in log.layout.joint_names]))
    after = t >= heard_s
    slower = np.max(rates[after], axis=1) < 0.999 * np.max(rates[after])
    began = np.argmax(np.max(rates[after], axis=1))  # it may still be speeding up
    return float(t[after][began + np.argmax(slower[began:])]) - heard_s


@pytest.mark.parametrize("script", [SCRIPTS[0], SCRIPTS[2], SCRIPTS[5]], ids=lambda script: script.name)
def test_the_default_filter_leaves_a_fifth_of_the_swing_or_less(script: Script, tmp_path: Path) -> None:
    shaped, unshaped = driven(script, None, tmp_path / "shaped"), driven(script, {"kind": "none"}, tmp_path / "unshaped")
    released_s = strokes(script)[1]
    left, without = (swing(read_log(path), released_s) for path in (shaped, unshaped))
    assert without.swing_mm > 5.0  # the arm does swing
    assert left.swing_mm <= 0.2 * without.swing_mm
    assert left.within_1mm_s < without.within_1mm_s
    assert slows_down_after(read_log(shaped), strokes(script)[0][-1][0]) <= 0.15
    for path in (shaped, unshaped):
        result = reexecute(path)
        assert result.identical, result.text()
    log = read_log(shaped)
    assert {stamped.point.wanted for stamped in log.set_points} == {Wanted.TIP if script.tip else Wanted.RATE, Wanted.END}
