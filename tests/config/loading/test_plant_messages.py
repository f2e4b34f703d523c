"""Mistakes in the plant section: the unit of a number there follows from its place, and a misspelt place is told as that."""

from __future__ import annotations

import pytest

from config.checking.check_plant import check_plant
from config.errors import ConfigError
from config.loading.load import apply_overrides, load_rig, rig_from_text
from config.parsing.yaml_tree import parse
from tests.support.config.small_rig import changed

PLANT = """\
plant:
  joints:
    axis: {actuator: force, travel: [-1 in, 50 in], gain: 35.15 N/V, mass: 95 kg}
  sensors:
    axis.position: {resolution: 25 um, low: -1 in, high: 50 in}
  effects:
    - {effect: coulomb_friction, where: axis, friction: 20 N}
"""
AXIS = changed(
    ("  axis.supply_pressure:\n    device: plant\n    channel: axis.supply_pressure\n    high: 3000 psi\n", ""),
    ("interlocks:\n  supply_pressure_min: 1500 psi\n", PLANT),
)


def message(old: str, new: str) -> str:
    assert AXIS.count(old) == 1
    with pytest.raises(ConfigError) as caught:
        rig_from_text(AXIS.replace(old, new), "x.yaml")
    return str(caught.value)


def test_the_unchanged_file_loads() -> None:
    plant = rig_from_text(AXIS).plant
    assert plant is not None
    assert plant.effects[0].model_dump()["friction"] == 20.0


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("friction: 20 N", "fricton: 20 N", "x.yaml:35:47: plant.effects[0].fricton is not a key here: nearest is 'friction'. "),
        ("friction: 20 N", "friction: 20 N*m", "x.yaml:35:57: plant.effects[0].friction: wrong kind of unit: '20 N*m'. Write it in N or "),
        ("friction: 20 N", "friction: -20 N", "x.yaml:35:57: plant.effects[0].friction is out of range: -20 N (limit: 0 to "),
        (
            "effect: coulomb_friction",
            "effect: coulom_friction",
            "x.yaml:35:16: plant.effects[0].effect cannot be 'coulom_friction': nearest is ",
        ),
        (
            "where: axis",
            "where: axs",
            "x.yaml:35:41: plant.effects[0].where: there is no 'axs' in this plant: nearest is 'axis'. Places: axis, ",
        ),
        (
            "axis.position: {res",
            "axis.positon: {res",
            "x.yaml:33:5: 'axis.positon' is not a signal of this plant: nearest is 'axis.position'",
        ),
        (
            "low: -1 in, high: 50 in",
            "low: 50 in, high: 50 in",
            "x.yaml:33:58: plant.sensors.axis.position.high: high must be above low: 50 in (limit: 50 in)",
        ),
        ("    motion: linear\n", "", "x.yaml:9:3: joints.axis needs the key 'motion'. Choose one of: rotary, linear."),
        ("motion: linear", "motion: linaer", "x.yaml:10:13: joints.axis.motion cannot be 'linaer': nearest is 'linear'"),
        ("actuator: force", "actuator: forc", "x.yaml:31:22: plant.joints.axis.actuator cannot be 'forc': nearest is 'force'. "),
    ],
)
def test_one_mistake_is_told_as_one(old: str, new: str, text: str) -> None:
    found = message(old, new)
    assert found.startswith(text)
    assert "\n" not in found


@pytest.mark.parametrize("grade", ["[32]", "{32: 46}", "47", "'46'"])
def test_an_oil_grade_that_is_none(grade: str) -> None:
    text = load_rig("analogue_axis").text.replace("iso_vg: 46", f"iso_vg: {grade}")
    with pytest.raises(ConfigError, match=r"x.yaml:\d+:\d+: plant.oil: iso_vg .* is none of 10, 15, 22, 32, 46"):
        rig_from_text(text, "x.yaml")


def test_a_second_entry_of_what_the_plant_has_once() -> None:
    """The tilt of an arm stands at either joint; two of them would contradict each other. What joints have may be at both."""
    tilts = "\n    - {effect: gravity, where: rotary, tilt: 1 deg}\n    - {effect: gravity, where: prismatic, tilt: 2 deg}"
    text = load_rig("ornl_testbed").text.replace("\n  effects:", f"\n  effects:{tilts}")
    with pytest.raises(ConfigError, match=r"entry 1 \(gravity at prismatic\) is there twice: it acts on the whole plant"):
        rig_from_text(text, "x.yaml")
    plant = rig_from_text(text.replace("gravity, where: rotary, tilt: 1 deg", "valve_null_bias, where: rotary, bias: 0.01"), "x.yaml").plant
    assert plant is not None
    assert [entry.effect for entry in plant.effects].count("valve_lag") == 2


def test_an_actuator_that_does_not_move_the_joint_that_way() -> None:
    assert "plant.joints.axis.actuator 'torque' does not move a linear joint" in message("actuator: force", "actuator: torque")


def test_effects_can_be_overridden_by_number() -> None:
    plant = rig_from_text(apply_overrides(AXIS, ["plant.effects.0.friction=25 N"])).plant
    assert plant is not None
    assert plant.effects[0].model_dump()["friction"] == 25.0


ENTRY = "effect: coulomb_friction, where: axis, friction: 20 N"
TABLE = "effect: unnamed_remainder, where: axis, "


@pytest.mark.parametrize(
    ("table", "text"),
    [
        (
            "position: [0 m, 1 m], force: [1 N]",
            "x.yaml:35:7: plant.effects[0]: position has 2 knots and force 1 values: give one force a knot",
        ),
        ("position: [0 m], force: [1 N]", "x.yaml:35:7: plant.effects[0]: position has 1 entries; a table has 2 to 8 knots"),
        (
            "command: [0, 1, 2, 3, 4, 5, 6, 7, 8], force: [0, 0, 0, 0, 0, 0, 0, 0, 0]",
            "x.yaml:35:7: plant.effects[0]: command has 9 entries; a table has 2 to 8 knots",
        ),
        (
            "velocity: [0.1 m/s, 0.1 m/s], force: [1 N, 2 N]",
            "x.yaml:35:58: plant.effects[0].velocity: knot 1 is 0.1 after 0.1; knots must increase: sort them, each with its force",
        ),
        ("position: [0 m, 1 m], velocity: [0, 1], force: [1, 2]", "there is velocity, position: keep one list of knots"),
        ("force: [1, 2]", "the force stands over exactly one of velocity, position, command, pressure_difference; there is none of them"),
        (
            "position: [0 m, 1 m], force: [1 N*m, 2 N*m]",
            "plant.effects[0].force: wrong kind of unit: ['1 N*m', '2 N*m']. Write it in N or ",
        ),
        ("position: [0 m, 1 m]", "plant.effects[0]: neither of force and friction: a table needs one of them"),
        ("position: [0 m, 1 m], force: [1, 2], friction: [1, 2]", "plant.effects[0]: both of force and friction"),
        ("velocity: [0, 1], friction: [1, 2]", "plant.effects[0]: friction stands over position, not over velocity: give it as a force"),
        ("position: [0 m, .inf], force: [1, 2]", "plant.effects[0].position: a finite number was expected: ['0 m', inf]"),
        ("pressure_difference: [0, 1 bar], force: [1, 2]", "needs a hydraulic actuator there for a table over pressure_difference"),
    ],
)
def test_a_table_that_is_none_is_refused(table: str, text: str) -> None:
    found = message(ENTRY, TABLE + table)
    assert found.startswith("x.yaml:3")
    assert text in found
    assert "\n" not in found


def test_a_table_at_no_joint_is_told_as_that() -> None:
    table = "effect: unnamed_remainder, where: sensor:axis.position, position: [0 m, 1 m], force: [1 N, 2 N]"
    assert "x.yaml:35:42: plant.effects[0].where: this effect belongs at a joint" in message(ENTRY, table)


@pytest.mark.parametrize(
    ("force", "drives"), [("[9 N, -9 N]", False), ("[9 N, 0.05 N]", False), ("[9 N, 2 N]", True), ("[-1 N, 1 N]", True)]
)
def test_a_table_that_pushes_along_is_warned_about(force: str, drives: bool) -> None:
    text = AXIS.replace(ENTRY, f"{TABLE}velocity: [-0.1 m/s, 0.1 m/s], force: {force}")
    warned = [
        f
        for f in check_plant(rig_from_text(text), parse(text, "axis.yaml"))
        if f.level == "warning" and "unnamed_remainder at axis pushes along" in f.text
    ]
    assert bool(warned) == drives
