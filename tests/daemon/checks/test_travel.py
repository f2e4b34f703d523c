"""The travel interlock: its limits as numbers, and an arm that drifts out of its travel."""

from __future__ import annotations

from math import radians
from pathlib import Path

import pytest

from config.errors import DaemonError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from daemon.checks.interlocks import interlocks, rig_facts
from daemon.lockstep import LockstepRig
from servo_control.signals import Mode
from tests.support.daemon.rigs import texts_of
from tests.support.daemon.simple_device import SimpleDevice, factory

INCH = 0.0254
END, MARGIN = radians(88.0), radians(5.0)  # of the testbed's rotary joint
JOG = {"maneuver": {"name": "jog"}, "parameters": {"joint": "prismatic", "by": "1 in", "speed": "0.2 in/s"}}
DRIFT = radians(0.01)  # a cycle, slow enough for the interlock of the rate


# Transducers that see more than the travel and its margin; a drift against the command is a fault of its own otherwise.
CHANGES = ["signals.rotary.position.low=-100 deg", "signals.rotary.position.high=100 deg", "interlocks.plausibility.flow=null"]


def drifting_rig(directory: Path, made: list[SimpleDevice]) -> LockstepRig:
    text = apply_overrides(load_rig("ornl_testbed").text, CHANGES)
    return LockstepRig(LoadedRig(rig_from_text(text), text, "wide.yaml"), directory, create=factory(made))


def test_the_limits_are_the_ends_of_the_travel_widened_by_the_following_error() -> None:
    rig = load_rig("ornl_testbed").rig
    checks = {check.name: check for check in interlocks(rig, rig_facts(rig))}
    rotary, prismatic = checks["rotary travel"], checks["prismatic travel"]
    assert (rotary.low, rotary.high) == pytest.approx((-radians(93.0), radians(93.0)))
    assert (prismatic.low, prismatic.high) == pytest.approx((11 * INCH, 61 * INCH))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_joint_that_drifts_out_of_its_travel_is_stopped_in_that_cycle(tmp_path: Path, side: float) -> None:
    made: list[SimpleDevice] = []
    with drifting_rig(tmp_path, made) as rig:
        position = made[0].override
        position["rotary.position"] = side * END
        rig.arm()
        rig.start(JOG)
        rig.until(lambda: rig.mode is Mode.RUNNING, 1.0)
        while rig.mode is Mode.RUNNING:
            before = abs(position["rotary.position"])
            position["rotary.position"] += side * DRIFT
            rig.cycles(1)
        assert rig.mode is Mode.STOPPING
        assert before <= END + MARGIN + 1e-9 < before + DRIFT
        assert "rotary travel (joint rotary)" in rig.loop.keeper.run.reason
        assert any("running → stopping" in text and "rotary travel" in text for text in texts_of(rig, "mode"))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_arm_outside_its_travel_is_not_armed(tmp_path: Path, side: float) -> None:
    made: list[SimpleDevice] = []
    with drifting_rig(tmp_path, made) as rig:
        made[0].override["rotary.position"] = side * (END + MARGIN + DRIFT)
        with pytest.raises(DaemonError, match=r"arming was refused: rotary travel \(joint rotary\): -?1\.62\d* rad .*Bring the joint back"):
            rig.arm()
        made[0].override["rotary.position"] = side * (END + MARGIN - DRIFT)
        rig.arm()
        assert rig.mode is Mode.HOLDING
