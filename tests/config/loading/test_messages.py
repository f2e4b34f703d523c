"""Bad rig files, each checked on the very text a user reads."""

from __future__ import annotations

import pytest

from config.errors import ConfigError, Refusal
from config.loading.load import maneuver_from_text, rig_from_text
from config.loading.shipped import find
from tests.support.config.small_rig import SMALL, changed

SHIPPED = find("rigs", "ornl_testbed").parents[1]
SERVO_KEYS = "sections, velocity_filter, gain, velocity_feedforward, null_bias, acceleration_feedforward, dither, oil_compensation"

ONE_PROBLEM = {
    "unknown key": (
        ("    gain: 8 V/in", "    gain: 8 V/in\n    velocity_filtr: 50 Hz"),
        f"x.yaml:18:5: servo.axis.velocity_filtr is not a key here: nearest is 'velocity_filter'. Keys of servo.axis: {SERVO_KEYS}.",
    ),
    "misspelt required key, told once": (
        ("    gain: 8 V/in", "    gian: 8 V/in"),
        f"x.yaml:17:5: servo.axis.gian is not a key here: nearest is 'gain'. Keys of servo.axis: {SERVO_KEYS}.",
    ),
    "unknown key like no other": (
        ("  kind: single_axis", "  kind: single_axis\n  zzz: 1"),
        "x.yaml:5:3: arm.zzz is not a key here. Keys of arm: kind, hub_offset.",
    ),
    "missing key": (
        ("    rate_limit: 10 in/s\n", ""),
        "x.yaml:9:3: joints.axis needs the key 'rate_limit'. Add rate_limit: ... (largest reference rate; in m/s; 1e-05 to 10 m/s).",
    ),
    "missing choice": (
        ("    motion: linear\n", ""),
        "x.yaml:9:3: joints.axis needs the key 'motion'. Choose one of: rotary, linear.",
    ),
    "wrong choice": (
        ("motion: linear", "motion: liner"),
        "x.yaml:10:13: joints.axis.motion cannot be 'liner': nearest is 'linear'. Allowed: rotary, linear.",
    ),
    "wrong word": (
        ("kind: single_axis", "kind: single"),
        "x.yaml:4:9: arm.kind cannot be 'single': nearest is 'single_axis'. Allowed: rotary_prismatic, single_axis.",
    ),
    "wrong kind of unit": (
        ("1500 psi", "1500 kg"),
        "x.yaml:34:24: interlocks.supply_pressure_min: wrong kind of unit: '1500 kg'. "
        "Write it in Pa or a unit convertible to it, for example '1.5 Pa'. Allowed: 0 to 4e+07 Pa.",
    ),
    "unknown unit": (
        ("8 V/in", "8 V/inn"),
        "x.yaml:17:11: servo.axis.gain: unknown unit: '8 V/inn'. Nearest is 'V/in'. "
        "Write it in V/m or a unit convertible to it, for example '1.5 V/m'. Allowed: -1e+06 to 1e+06 V/m.",
    ),
    "unknown unit in a list": (
        ("[0 in, 48 in]", "[0 in, 48 inn]"),
        "x.yaml:11:20: joints.axis.travel[1]: unknown unit: '48 inn'. "
        "Nearest is 'in'. Write it in m or a unit convertible to it, for example '1.5 m'.",
    ),
    "gauge pressure": (
        ("1500 psi", "1500 psig"),
        "x.yaml:34:24: interlocks.supply_pressure_min: unknown unit: '1500 psig'. Nearest is 'psi'. "
        "Write it in Pa or a unit convertible to it, for example '1.5 Pa'. Allowed: 0 to 4e+07 Pa.",
    ),
    "a unit like none": (
        ("1500 psi", "1500 xyzzy"),
        "x.yaml:34:24: interlocks.supply_pressure_min: unknown unit: '1500 xyzzy'. "
        "Write it in Pa or a unit convertible to it, for example '1.5 Pa'. Allowed: 0 to 4e+07 Pa.",
    ),
    "no number": (
        ("8 V/in", "high"),
        "x.yaml:17:11: servo.axis.gain: not a number with a unit: 'high'. "
        "Write it in V/m or a unit convertible to it, for example '1.5 V/m'. Allowed: -1e+06 to 1e+06 V/m.",
    ),
    "wrong unit in a list": (
        ("[0 in, 48 in]", "[0 in, 48 s]"),
        "x.yaml:11:20: joints.axis.travel[1]: wrong kind of unit: '48 s'. Write it in m or a unit convertible to it, for example '1.5 m'.",
    ),
    "out of range, in the user's unit and in SI": (
        ("rate: 500 Hz", "rate: 5 kHz"),
        "x.yaml:6:9: loop.rate is out of range: 5 kHz (limit: 0.01 to 2 kHz, which is 10 to 2000 Hz)",
    ),
    "out of range, bare number": (
        ("rate: 500 Hz", "rate: 5"),
        "x.yaml:6:9: loop.rate is out of range: 5 Hz (limit: 10 to 2000 Hz)",
    ),
    "out of range, whole number": (
        ("rate: 500 Hz", "priority: 99"),
        "x.yaml:6:13: loop.priority is out of range: 99 (limit: 0 to 98)",
    ),
    "not a whole number": (
        ("rate: 500 Hz", "priority: high"),
        "x.yaml:6:13: loop.priority must be a whole number: got 'high'",
    ),
    "a truth is no number": (
        ("rate: 500 Hz", "rate: true"),
        "x.yaml:6:9: loop.rate: a number was expected: True. Allowed: 10 to 2000 Hz.",
    ),
    "limits the wrong way round": (
        ("[0 in, 48 in]", "[48 in, 0 in]"),
        "x.yaml:11:13: joints.axis.travel: travel must be [lower, upper] with lower < upper: got ['48 in', '0 in']",
    ),
    "low above high": (
        ("high: 49 in", "high: -2 in"),
        "x.yaml:26:11: signals.axis.position.high: high must be above low: -2 in (limit: -1 in)",
    ),
    "a pressure above its maximum, which is a bare number": (
        ("1500 psi", "1500 psi\n  supply_pressure_max: 900"),
        "x.yaml:35:24: interlocks.supply_pressure_max: the maximum must be above the minimum: 900 Pa (limit: 1500 psi)",
    ),
    "too many entries": (
        ("[0 in, 48 in]", "[0, 1, 2]"),
        "x.yaml:11:13: joints.axis.travel must have at most 2 entries: got [0, 1, 2]",
    ),
    "value instead of a section": (
        ("{driver: sim}", "sim"),
        "x.yaml:19:10: devices.plant must be a section (key: value lines): got 'sim'",
    ),
    "duplicate key": (
        ("    gain: 8 V/in", "    gain: 8 V/in\n    gain: 9 V/in"),
        "x.yaml:18:5: servo.axis.gain stands twice: first on line 17. Remove one.",
    ),
    "YAML syntax": (
        ("name: bench", "name: bench: 2"),
        "x.yaml:2:12: not readable as YAML: mapping values are not allowed here",
    ),
    "alias": (
        ("name: bench", "name: &n bench"),
        "x.yaml:2:7: not readable as YAML: anchors and aliases (& and *) are not used here; write the value out",
    ),
    "maneuver given as rig": (
        ("longreach: rig/1", "longreach: maneuver/1"),
        "x.yaml:1:12: this file is 'maneuver/1', not 'rig/1'. A rig file begins with longreach: rig/1.",
    ),
    "unknown signal": (
        ("  axis.supply_pressure:\n", "  axis.supply_presure: {device: plant, channel: x}\n  axis.supply_pressure:\n"),
        "x.yaml:27:3: 'axis.supply_presure' is not a signal of this rig: nearest is 'axis.supply_pressure'",
    ),
    "unknown device": (
        ("axis: {device: plant", "axis: {device: plnt"),
        "x.yaml:32:18: outputs.axis: there is no device 'plnt': nearest is 'plant'. Devices: plant.",
    ),
    "position must be fitted": (
        ("    high: 49 in", "    high: 49 in\n    required: false"),
        "x.yaml:27:15: axis.position closes the loop and cannot be optional. Remove required: false.",
    ),
    "motion belongs to the joint": (
        ("    gain: 8 V/in", "    gain: 8 V/in\n    motion: linear"),
        "x.yaml:18:5: servo.axis.motion is not a key here. Remove it: it follows from joints.axis.motion.",
    ),
    "interlock without its signal": (
        ("  supply_pressure_min: 1500 psi", "  oil_temperature_max: 60 degC"),
        "x.yaml:34:3: interlocks.oil_temperature_max needs a signal reservoir_temperature, which is not in signals. "
        "Add the signal, or remove the limit.",
    ),
    "output to a slow device": (
        ("{driver: sim}", "{driver: sim, slow: true}"),
        "x.yaml:32:18: outputs.axis goes to the slow device 'plant'. A joint's command must be written inside the loop: slow: false.",
    ),
    "arm that needs more joints": (
        ("kind: single_axis", "kind: rotary_prismatic"),
        None,
    ),
}


@pytest.mark.parametrize("case", [name for name, (_, text) in ONE_PROBLEM.items() if text])
def test_a_single_problem_reads_as_written_here(case: str) -> None:
    replacement, text = ONE_PROBLEM[case]
    with pytest.raises(ConfigError) as caught:
        rig_from_text(changed(replacement), "x.yaml")
    assert str(caught.value) == text
    assert len(caught.value.problems) == 1


def test_all_problems_are_told_at_once_in_the_order_of_the_file() -> None:
    text = changed(
        ("1500 psi", "1500 kg"), ("rate: 500 Hz", "rate: 5 kHz"), ("gain: 8 V/in", "gain: 8 V/in\n    gian: 2"), ("sim}", "sim, sim: 1}")
    )
    with pytest.raises(ConfigError) as caught:
        rig_from_text(text, "x.yaml")
    assert [refusal.where for refusal in caught.value.problems] == ["x.yaml:6:9", "x.yaml:18:5", "x.yaml:20:24", "x.yaml:35:24"]
    assert str(caught.value).startswith("4 problems in x.yaml:\n  x.yaml:6:9: loop.rate is out of range")


def test_wrong_joints_servo_and_outputs_are_matched_by_name() -> None:
    with pytest.raises(ConfigError) as caught:
        rig_from_text(changed(("servo:\n  axis:", "servo:\n  axes:"), ("  axis: {device", "  asix: {device")), "x.yaml")
    assert [refusal.text() for refusal in caught.value.problems] == [
        "x.yaml:15:1: servo has no entry for the joint 'axis'. Add servo.axis.",
        "x.yaml:16:3: servo.axes belongs to no joint: nearest is 'axis'. Joints: axis.",
        "x.yaml:31:1: outputs has no entry for the joint 'axis'. Add outputs.axis.",
        "x.yaml:32:3: outputs.asix belongs to no joint: nearest is 'axis'. Joints: axis.",
    ]


def test_a_rotary_prismatic_arm_needs_its_joints_and_its_link() -> None:
    with pytest.raises(ConfigError) as caught:
        rig_from_text(changed(ONE_PROBLEM["arm that needs more joints"][0]), "x.yaml")
    assert [refusal.what for refusal in caught.value.problems] == [
        "a rotary_prismatic arm needs the section 'link_mode'",
        "a rotary_prismatic arm needs a joint named 'rotary'",
        "a rotary_prismatic arm needs a joint named 'prismatic'",
        "a rotary_prismatic arm has the joints rotary and prismatic, not 'axis'",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", f"x.yaml:1:1: the file is empty. Start from a shipped file: `ls {SHIPPED / 'rigs'} {SHIPPED / 'maneuvers'}`."),
        ("- 1\n", "x.yaml:1:1: the file must be a mapping of keys to values (key: value)"),
        ("a: \x01\n", "x.yaml:1:4: not readable as YAML: character '\\x01' is not allowed"),
        ("name: x\n", "x.yaml:1:1: the key 'longreach' is missing, which says what this file is. A rig file begins with longreach: rig/1."),
        (
            "longreach: rig/1\n---\na: 1\n",
            "x.yaml:2:1: not readable as YAML: but found another document (expected a single document in the stream)",
        ),
    ],
)
def test_files_that_are_no_rig_at_all(text: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        rig_from_text(text, "x.yaml")
    assert str(caught.value) == message


def problems_of(text: str) -> tuple[Refusal, ...]:
    try:
        rig_from_text(text, "x.yaml")
    except ConfigError as error:
        return error.problems
    return ()


def test_every_single_line_removed_gives_a_rig_or_a_placed_error() -> None:
    lines = SMALL.splitlines(keepends=True)
    for number in range(len(lines)):
        text = "".join(lines[:number] + lines[number + 1 :])
        assert all(refusal.where.startswith("x.yaml:") for refusal in problems_of(text)), lines[number]


def test_a_maneuver_is_refused_in_the_same_way() -> None:
    text = (
        "longreach: maneuver/1\nname: line\nkind: straight_line\ny0: 30 kg\nmoves: [1 in, 2 s]\nspeed: 10 in/s\nacceleration: 100 in/s^2\n"
    )
    with pytest.raises(ConfigError) as caught:
        maneuver_from_text(text, "m.yaml")
    assert [refusal.where for refusal in caught.value.problems] == ["m.yaml:4:5", "m.yaml:5:15"]
    with pytest.raises(ConfigError, match=r"m.yaml:3:7: kind cannot be 'straight': nearest is 'straight_line'"):
        maneuver_from_text(text.replace("straight_line", "straight"), "m.yaml")


def test_a_wrong_entry_is_not_a_missing_one() -> None:
    text = "longreach: maneuver/1\nname: s\nkind: joint_steps\nsteps:\n  - {joint: axis, by: 1 mm, to: 2 mm}\n"
    with pytest.raises(ConfigError) as caught:
        maneuver_from_text(text, "m.yaml")
    assert str(caught.value).startswith("m.yaml:5:5: steps[0]: a step needs either `to` or `by`")
    assert len(caught.value.problems) == 1
    with pytest.raises(ConfigError, match=r"m.yaml:4:8: steps must have at least 1 entries: got \[\]"):
        maneuver_from_text(text.replace("\n  - {joint: axis, by: 1 mm, to: 2 mm}", " []"), "m.yaml")


def test_a_value_that_is_a_sentence_ends_with_one_stop() -> None:
    assert Refusal("nothing was found", "The log is empty.", next_step="Record one.").text() == (
        "nothing was found: The log is empty. Record one."
    )
