"""Which shipped maneuvers a rig can run: the testbed all, one axis those that name no joint of others."""

from __future__ import annotations

import pytest

from config.loading.load import load_maneuver, load_rig
from config.loading.shipped import shipped
from servo_control.planning.runnable import why_not


def reasons(rig: str) -> dict[str, str]:
    return {name: why_not(load_rig(rig).rig, load_maneuver(path).maneuver) for name, path in shipped("maneuvers").items()}


def test_the_testbed_runs_every_shipped_maneuver() -> None:
    found = reasons("ornl_testbed")
    assert found
    assert set(found.values()) == {""}


def test_a_single_axis_runs_those_that_name_no_other_joint() -> None:
    found = reasons("cu_rigid_arm")
    assert [name for name, reason in found.items() if not reason] == ["hold"]
    assert found["jog"] == "the rig has no such joint: rotary (limit: hub). Name hub, with ways and speeds in its unit."


@pytest.mark.parametrize("name", ["paper_line", "staircase"])
def test_a_shorter_arm_is_told_which_limit_it_would_meet(name: str) -> None:
    assert "is above the limit 0.5000 m" in reasons("cu_flexible_arm")[name]
