"""A shaped run through the daemon on the wall clock leaves what the same run leaves in lockstep."""

from __future__ import annotations

from math import sqrt
from pathlib import Path
from typing import Any

import pytest
from running_daemon import RunningDaemon, arm, patient_rig

from config.load import load_rig
from config.rig import Rig
from daemon.cli.main import main
from daemon.lockstep import run_lockstep
from recording.reader import read_log
from recording.vibration import PERIODS, HoldVibration, hold_vibration, rms_mps2

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
    """Tip acceleration as logged, root mean square over the three holds; 2 dB and what the accelerometer's noise can make of it."""
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
    rig = load_rig(patient_rig(tmp_path / "clock")).rig
    difference, two_dB = rms_mps2(on_the_clock) - rms_mps2(in_lockstep), 10.0 ** (2.0 / 20.0) - 1.0
    assert abs(difference) < two_dB * rms_mps2(in_lockstep) + 3.0 * noise_mps2(rig, in_lockstep), (on_the_clock, in_lockstep)


def noise_mps2(rig: Rig, holds: list[HoldVibration]) -> float:
    """Standard deviation that the accelerometer's noise σ gives the difference of two such figures: σ √(2/N) an amplitude, N the samples in
    its window; a mean over the holds, twice. What zero_delay leaves is no more than a few of it."""
    assert rig.plant is not None
    samples = [rig.loop.rate_Hz * PERIODS / hold.frequency_Hz for hold in holds]
    return rig.plant.sensors["tip.acceleration"].noise * sqrt(2.0 * sum(2.0 / n for n in samples)) / len(holds)


def _made(directory: Path) -> Path:
    directory.mkdir(exist_ok=True)
    return directory
