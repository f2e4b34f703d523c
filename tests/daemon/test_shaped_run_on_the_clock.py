"""A shaped run through the daemon on the wall clock leaves what the same run leaves in lockstep."""

from __future__ import annotations

from math import log10
from pathlib import Path

import pytest
from running_daemon import RunningDaemon, arm, patient_rig

from config.load import load_rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from recording.reader import read_log
from recording.vibration import hold_vibration, rms_mps2

pytestmark = pytest.mark.slow
WORDS = ("start", "paper_line", "--shaper", "adaptive", "--both-joints", "--approach", "--countdown", "0", "--wait", "--json")
REQUEST = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": "adaptive", "joints": ["rotary", "prismatic"]}, "approach": True}


def test_the_holds_are_those_of_lockstep_within_2_dB(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """y0 = 40 in, tip acceleration as logged, root mean square over the three holds."""
    with RunningDaemon(tmp_path / "clock", str(patient_rig(_made(tmp_path / "clock")))) as daemon, daemon.wait_until_ready() as client:
        arm(client)
        assert main(["--socket", str(daemon.socket), *WORDS]) == 0, capsys.readouterr()
        client.call("disarm")
        on_the_clock = hold_vibration(read_log(daemon.latest_log()))
    (path,) = run_lockstep(load_rig(patient_rig(tmp_path / "clock")), [REQUEST], _made(tmp_path / "lockstep"))
    in_lockstep = hold_vibration(read_log(path))
    assert [hold.move for hold in on_the_clock] == [hold.move for hold in in_lockstep]
    assert len(in_lockstep) == 3
    difference_dB = 20.0 * log10(rms_mps2(on_the_clock) / rms_mps2(in_lockstep))
    assert abs(difference_dB) < 2.0, (on_the_clock, in_lockstep)


def _made(directory: Path) -> Path:
    directory.mkdir(exist_ok=True)
    return directory
