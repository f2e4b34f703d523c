"""What a refused maneuver is told to change is enough, also as it is shown: with four digits, in the units of a rig file."""

from __future__ import annotations

from math import hypot, pi, radians
from typing import Any

import pytest
import yaml

from config.errors import ManeuverError
from config.loading.load import find
from config.loading.stated_units import sentence_units
from config.schema.maneuver import maneuver_content, maneuver_from_content
from config.schema.rig import Rig
from config.stated_sentences import StatedSentences
from servo_control.planning.mending import mended, plan_or_mend
from servo_control.planning.planning import plan_run
from servo_control.planning.runnable import why_not
from tests.support.servo_control.testbed_runs import INCH, content, request

HOME = [0.0, 0.9144]
SWEEP = {"joint": "rotary", "from": 0.1, "to": 5, "duration": 20}


def line(**values: Any) -> dict[str, Any]:
    rest = {"y0": 40 * INCH, "moves": [30 * INCH, -60 * INCH, 30 * INCH], "speed": 10 * INCH, "acceleration": 100 * INCH}
    return content("straight_line", **(rest | values))


REFUSED = [
    (line(y0=10 * INCH), ["y0"]),
    (line(y0=2.0), ["y0"]),
    (line(moves=[1.8, -1.8]), ["moves"]),
    (line(moves=[1.8, -1.8], y0=0.1), ["y0", "moves"]),
    (line(y0=0.4, speed=1.0, acceleration=20.0), ["speed", "acceleration"]),
    (line(y0=0.1, speed=0.9, moves=[0.9, -0.9]), ["y0", "speed", "acceleration"]),
    (content("jog", joint="rotary", by="100 deg"), ["by"]),
    (content("jog", joint="rotary", by="-60 deg", speed="100 deg/s"), ["speed"]),
    (content("fast_strokes", joint="prismatic", by="3 m", speed="9 m/s", acceleration="99 m/s^2"), ["by", "speed", "acceleration"]),
    (content("slow_triangle", joint="rotary", amplitude="100 deg", rate="200 deg/s"), ["amplitude", "rate"]),
    (content("slow_triangle", joint="rotary", on="command", amplitude="9 V", rate="1 V/s"), ["amplitude"]),
    (content("staircase", joint="prismatic", step="-10 in", steps=6), ["step"]),
    (content("staircase", joint="rotary", on="command", step="2 V", steps=3), ["step"]),
    (content("sine_sweep", amplitude="5 deg", **SWEEP), ["amplitude"]),
    (content("sine_sweep", on="command", amplitude="2 V", **SWEEP), ["amplitude"]),
    (content("multisine", joint="rotary", amplitude="40 deg", **{"from": 0.1, "to": 2}), ["amplitude"]),
    (content("sine_sweep", amplitude="1 deg", start={"prismatic": "80 in"}, **SWEEP | {"to": 2}), ["start"]),
    (content("joint_steps", steps=[{"joint": "rotary", "to": "2 rad"}, {"joint": "prismatic", "by": 0.1, "speed": 9.0}]), ["steps"]),
]


def changed(maneuver: dict[str, Any], changes: dict[str, str]) -> dict[str, Any]:
    """As a user who writes the values into his file."""
    written = {key: yaml.safe_load(value) for key, value in changes.items()}
    return maneuver_content(maneuver_from_content({**maneuver, **written}))


@pytest.mark.parametrize(("maneuver", "keys"), REFUSED, ids=[f"{maneuver['kind']} {'+'.join(keys)}" for maneuver, keys in REFUSED])
def test_the_values_told_are_enough_in_si_and_as_shown(rig: Rig, maneuver: dict[str, Any], keys: list[str]) -> None:
    asked = request(maneuver, () if maneuver["kind"] == "straight_line" else HOME)
    with pytest.raises(ManeuverError) as refused:
        plan_or_mend(rig, asked)
    mend = refused.value.refusal.mend
    assert list(mend) == keys
    shown = StatedSentences(sentence_units(find("rigs", "ornl_testbed").read_text(encoding="utf-8"))).refusal(refused.value).refusal.mend
    assert any("in" in str(value) or "deg" in str(value) or " V" in str(value) for value in shown.values())
    for changes in (mend, shown):
        plan_run(rig, request(changed(maneuver, {key: str(value) for key, value in changes.items()}), asked.start_position))


VOLTS = {"joint": "rotary", "on": "command", "amplitude": "0.1 V"}
SLOW_LOOP = [
    (content("sine_sweep", **SWEEP | VOLTS | {"to": 190}), ["to"], "190 Hz .limit: 40 Hz"),
    (content("multisine", **VOLTS, lines=5, period=1, **{"from": 45, "to": 60}), ["from", "to"], "60 Hz .limit: 40 Hz"),
]


@pytest.mark.parametrize(("maneuver", "keys", "words"), SLOW_LOOP, ids=lambda value: value["kind"] if isinstance(value, dict) else "")
def test_an_excitation_is_no_faster_than_the_loop_can_make_it(rig: Rig, maneuver: dict[str, Any], keys: list[str], words: str) -> None:
    """At 100 cycles per second 190 Hz would come out as 10 Hz; a logged run with it is still planned as it was."""
    slow = rig.model_copy(update={"loop": rig.loop.model_copy(update={"rate_Hz": 100.0})})
    with pytest.raises(ManeuverError, match=f"too fast for the loop, 100 Hz: {words}") as refused:
        plan_or_mend(slow, request(maneuver, HOME))
    assert refused.value.refusal.mend == dict.fromkeys(keys, "40 Hz")
    assert why_not(slow, maneuver_from_content(maneuver)).endswith("or a faster loop.")
    plan_run(slow, request(maneuver, HOME))
    mended_one = changed(maneuver, {"to": "40 Hz"} if keys == ["to"] else {"from": "10 Hz", "to": "40 Hz"})
    assert plan_or_mend(slow, request(mended_one, HOME)).duration_s > 0.0


def test_little_more_is_changed_than_has_to_be(rig: Rig) -> None:
    """By the geometry of the line alone: 12 in is the shortest extension, 60 in the longest at its ends."""
    near, far = (float(mended(rig, request(line(y0=y0_m)))["y0"].split()[0]) for y0_m in (0.1, 3.0))
    assert 12 * INCH < near < 12.1 * INCH
    assert 59.8 * INCH < hypot(far, 30 * INCH) < 60 * INCH


TONE = {"joint": "rotary", "from": 3.0, "to": 3.0001, "duration": 20, "fade": 9}  # faded slowly, which adds next to nothing
# Key, and what the rig allows of it: by hand, from the testbed's limits and where the arm stands.
ALLOWED = [
    (content("jog", joint="rotary", by="100 deg"), "by", radians(88.0)),
    (content("jog", joint="rotary", by="-100 deg"), "by", -radians(88.0)),
    (content("jog", joint="prismatic", by="3 m"), "by", 60 * INCH - HOME[1]),
    (content("jog", joint="prismatic", by="-3 m"), "by", 12 * INCH - HOME[1]),
    (content("jog", joint="rotary", by="30 deg", speed="100 deg/s"), "speed", radians(60.0)),
    (content("fast_strokes", joint="prismatic", by="10 in", acceleration="99 m/s^2"), "acceleration", 130 * INCH),
    (content("sine_sweep", amplitude="5 deg", **TONE), "amplitude", radians(600.0) / (2 * pi * 3.0) ** 2),  # a = A w^2
    (content("sine_sweep", amplitude="12 deg", **TONE | {"from": 1.0, "to": 1.0001}), "amplitude", radians(60.0) / (2 * pi)),  # v = A w
    (content("sine_sweep", on="command", amplitude="2 V", **TONE), "amplitude", 5.0 * 0.35),  # following error x gain
    (line(y0=0.4, moves=[0.1, -0.2, 0.1], speed=0.6, acceleration=2.54), "speed", 0.4 * radians(60.0)),  # v = y0 w, beside the hub
]


@pytest.mark.parametrize(("maneuver", "key", "allowed"), ALLOWED, ids=[f"{each['kind']} {key} {most:.3g}" for each, key, most in ALLOWED])
def test_what_is_told_is_the_most_that_the_limit_allows(rig: Rig, maneuver: dict[str, Any], key: str, allowed: float) -> None:
    told = mended(rig, request(maneuver, () if maneuver["kind"] == "straight_line" else HOME))
    assert 0.997 < float(told[key].split()[0]) / allowed < 1.0


@pytest.mark.parametrize(
    "maneuver",
    [
        content("jog", joint="elbow", by=0.1),
        content("jog", joint="prismatic", by="20 deg"),
        content("joint_steps", steps=[{"joint": "rotary", "by": 0.1, "speed": -1.0}]),
        content("multisine", joint="rotary", amplitude="1 deg", **{"from": 0.11, "to": 0.19}, period=10),
        line(x_start=9.0),
    ],
)
def test_what_no_such_change_mends_is_told_without_one(rig: Rig, maneuver: dict[str, Any]) -> None:
    with pytest.raises(ManeuverError) as refused:
        plan_or_mend(rig, request(maneuver, () if maneuver["kind"] == "straight_line" else HOME))
    assert refused.value.refusal.mend == {}


def test_an_arm_elsewhere_wants_an_approach(rig: Rig) -> None:
    with pytest.raises(ManeuverError, match="not at the start") as refused:
        plan_or_mend(rig, request(line(), [0.3, 1.2]))
    assert refused.value.refusal.mend == {"--approach": ""}


def test_what_to_change_is_told_of_an_arm_elsewhere_too(rig: Rig) -> None:
    mend = mended(rig, request(line(y0=10 * INCH), [0.3, 1.2]))
    assert list(mend) == ["y0", "--approach"]
    assert mend["--approach"] == ""
