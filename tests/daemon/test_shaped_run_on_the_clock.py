"""A shaped run through the daemon on the wall clock leaves what the same run leaves in lockstep."""

from __future__ import annotations

from math import log10
from pathlib import Path
from typing import Any

import pytest
from running_daemon import RunningDaemon, arm, patient_rig

from config.load import load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from recording.reader import read_log
from recording.vibration import hold_vibration, rms_mps2

pytestmark = pytest.mark.slow
OPTIONS = ("--approach", "--countdown", "0", "--wait", "--json")
BOTH = ["rotary", "prismatic"]


ADAPTIVE = {"kind": "adaptive", "joints": BOTH}, ("--shaper", "adaptive", "--both-joints")
ZERO_DELAY = {"kind": "zero_delay"}, ("--shaper", "zero_delay")


@pytest.mark.parametrize(
    ("maneuver", "shaper", "words"),
    [("paper_line", *ADAPTIVE), ("paper_line", *ZERO_DELAY), ("paper_line_y30", *ZERO_DELAY)],
    ids=["adaptive, 40 in", "zero_delay, 40 in", "zero_delay, 30 in"],
)
def test_the_holds_are_those_of_lockstep_within_2_dB(
    maneuver: str, shaper: dict[str, Any], words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Tip acceleration as logged, root mean square over the three holds."""
    request = {"maneuver": {"name": maneuver}, "shaper": shaper, "approach": True}
    with RunningDaemon(tmp_path / "clock", str(patient_rig(_made(tmp_path / "clock")))) as daemon, daemon.wait_until_ready() as client:
        arm(client)
        assert main(["--socket", str(daemon.socket), "start", maneuver, *words, *OPTIONS]) == 0, capsys.readouterr()
        client.call("disarm")
        on_the_clock = hold_vibration(read_log(daemon.latest_log()))
    (path,) = run_lockstep(load_rig(patient_rig(tmp_path / "clock")), [request], _made(tmp_path / "lockstep"))
    in_lockstep = hold_vibration(read_log(path))
    assert [hold.move for hold in on_the_clock] == [hold.move for hold in in_lockstep]
    assert len(in_lockstep) == 3
    difference_dB = 20.0 * log10(rms_mps2(on_the_clock) / rms_mps2(in_lockstep))
    assert abs(difference_dB) < 2.0, (on_the_clock, in_lockstep)


def _made(directory: Path) -> Path:
    directory.mkdir(exist_ok=True)
    return directory
