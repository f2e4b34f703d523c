"""What may run and what is refused, with the words the operator reads."""

from __future__ import annotations

import json
import pickle
from math import radians, sqrt
from typing import Any

import pytest

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from tests.support.servo_control.testbed_runs import INCH, content, request

HOME = [0.0, 0.9144]


def _line(y0: float, **values: Any) -> dict[str, Any]:
    rest = {"moves": [30 * INCH, -60 * INCH, 30 * INCH], "speed": 10 * INCH, "acceleration": 100 * INCH}
    return content("straight_line", y0=y0, **(rest | values))


def _refusal(rig: Rig, asked: RunRequest) -> str:
    with pytest.raises(ManeuverError) as refusal:
        plan_run(rig, asked)
    return str(refusal.value)


def test_line_too_near_names_extension_limit_and_the_right_y0(rig: Rig) -> None:
    text = _refusal(rig, request(_line(10 * INCH)))
    assert text == ("test: extension 0.2540 m at t = 0.00 s is below the limit 0.3048 m. Choose y0 ≥ 0.3048 m and y0 ≤ 1.3198 m.")
    assert sqrt(1.524**2 - 0.762**2) == pytest.approx(1.3198, abs=1e-4)


def test_feasible_y0_is_12_to_51_96_inches(rig: Rig) -> None:
    """Row 18. The joints' own rate limits allow the nearest line too."""
    plan_run(rig, request(_line(12 * INCH)))
    plan_run(rig, request(_line(51.961 * INCH)))
    assert "above the limit 1.5240 m" in _refusal(rig, request(_line(51.97 * INCH)))


def test_line_too_long_for_the_arm(rig: Rig) -> None:
    assert "No y0 fits: |x| reaches 1.6000 m" in _refusal(rig, request(_line(1.0, moves=[1.6])))


REFUSED = [
    (_line(0.4, speed=1.0, acceleration=20.0), "rotary acceleration at t = "),
    (_line(0.4, speed=0.9, moves=[0.9, -0.9], acceleration=2.54), "rotary rate at t = "),
    (
        content("jog", joint="rotary", by="100 deg"),
        "rotary position 1.7453 rad (100.00°) at t = 8.",
    ),  # the end, not where it leaves the travel
    (content("jog", joint="elbow", by=0.1), "no such joint: elbow (limit: rotary, prismatic)"),
    (content("jog", joint="prismatic", by="20 deg"), "test, by: wrong kind of unit for the joint prismatic: 0.349066 rad (limit: m)"),
    (content("jog", joint="rotary", by="60 deg", speed="100 deg/s"), "rotary rate at t = "),
    (content("sine_sweep", joint="rotary", amplitude="5 deg", **{"from": 0.1, "to": 10}, duration=20), "rotary acceleration at t = "),
    (content("sine_sweep", joint="rotary", on="command", amplitude="2 deg", **{"from": 1, "to": 2}, duration=9), "is in volts"),
    (
        content("sine_sweep", joint="rotary", on="command", amplitude="2 V", **{"from": 1, "to": 2}, duration=9),
        "Choose an amplitude of at most 1.75 V",
    ),
    (content("staircase", joint="rotary", on="command", step="2 V", steps=3), "above the command limit: 6 V (limit: 5 V)"),
    (content("multisine", joint="rotary", amplitude="1 deg", **{"from": 0.11, "to": 0.19}, period=10), "no line"),
    (content("joint_steps", steps=[{"joint": "rotary", "by": 0.1, "speed": -1.0}]), "the speed of rotary must be above 0: -1 rad/s."),
    (content("jog", joint="rotary", by=0.1, speed="-2 deg/s"), "the speed of rotary must be above 0: -0.0349066 rad/s."),
    (
        content("slow_triangle", joint="rotary", on="command", amplitude="0.3 V", rate="0 V/s"),
        "test, rate: a triangle needs a slope: 0 V/s (limit: > 0 V/s)",
    ),
    (content("slow_triangle", joint="rotary", on="command", amplitude="0.3 V", rate="-0.1 V/s"), "needs a slope: -0.1 V/s"),
    (content("slow_triangle", joint="rotary", on="command", amplitude="0 V", rate="0.1 V/s"), "test, amplitude: a triangle needs an amp"),
    (content("slow_triangle", joint="prismatic", amplitude="2 cm", rate="-1 mm/s"), "needs a slope: -0.001 m/s (limit: > 0 m/s)"),
]


@pytest.mark.parametrize(("maneuver", "words"), REFUSED, ids=[words[:25] for _, words in REFUSED])
def test_refusals(rig: Rig, maneuver: dict[str, Any], words: str) -> None:
    start = HOME if maneuver["kind"] != "straight_line" else ()
    assert words in _refusal(rig, request(maneuver, start))


def test_sweep_is_refused_only_above_its_own_rate(rig: Rig) -> None:
    """A ω² = 10.47 rad/s² of the rotary joint: at 0.02 rad the sweep may go to 3.64 Hz."""
    sweep = {"joint": "rotary", "amplitude": 0.02, "from": 0.5, "duration": 60.0, "fade": 1.0}
    limit_Hz = min(1.0471975 / 0.02, sqrt(10.471975 / 0.02)) / 6.283185
    plan_run(rig, request(content("sine_sweep", **sweep, to=0.99 * limit_Hz), HOME))
    assert "acceleration" in _refusal(rig, request(content("sine_sweep", **sweep, to=1.06 * limit_Hz), HOME))


def test_arm_elsewhere_is_refused_or_taken_there(rig: Rig, paper_y30: dict[str, Any]) -> None:
    far = [0.3, 1.2]
    text = _refusal(rig, request(paper_y30, far))
    assert "rotary is at 0.3000 rad (17.19°), the start is 0.0000 rad (0.00°)" in text
    assert "approach" in text
    plan = plan_run(rig, request(paper_y30, far, approach=True))
    assert [s.name for s in plan.segments[:3]] == ["approach", "settle", "move 1"]
    assert plan.start_position == pytest.approx(far, abs=1e-12)
    samples = [plan.program.at(t * 0.01, 0) for t in range(int(100 * plan.segments[0].end_s))]
    for j, joint in enumerate(rig.joints.values()):
        assert max(abs(rates[j]) for _, rates, _, _ in samples) <= 0.2 * joint.rate_limit * (1 + 1e-9)
    shares = [((p[0] - 0.3) / -0.3, (p[1] - 1.2) / (0.762 - 1.2)) for p, *_ in samples]
    assert all(a == pytest.approx(b, abs=1e-9) for a, b in shares), "both joints are equally far on their way"


@pytest.mark.parametrize(("offset", "fits"), [((0.0034, 0.0), True), ((0.0036, 0.0), False), ((0.0, 0.0019), True), ((0.0, 0.0021), False)])
def test_start_tolerance_is_0_2_degrees_and_2_mm(rig: Rig, paper_y30: dict[str, Any], offset: tuple[float, float], fits: bool) -> None:
    asked = request(paper_y30, [offset[0], 0.762 + offset[1]])
    if fits:
        assert plan_run(rig, asked).segments[0].name == "move 1"
    else:
        assert "not at the start" in _refusal(rig, asked)


@pytest.mark.parametrize("here", [[float("nan"), 0.762], [0.0, float("inf")], [0.0], [0.0, 0.762, 0.0]])
@pytest.mark.parametrize("approach", [False, True])
def test_a_start_position_that_is_none_is_refused(rig: Rig, paper_y30: dict[str, Any], here: list[float], approach: bool) -> None:
    """NaN is never farther from the start than the tolerance."""
    asked = request(paper_y30, here, approach=approach)
    assert "start_position needs a number for every joint" in _refusal(rig, asked)
    assert "(limit: 2 finite values)" in _refusal(rig, asked)


def test_repeat_returns_to_the_start(rig: Rig, paper_y30: dict[str, Any]) -> None:
    closed = plan_run(rig, request(paper_y30, repeat=3))
    assert len(closed.segments) == 18
    assert closed.segments[6].name == "move 1, pass 2"
    assert closed.program.duration_s == pytest.approx(3 * 18.3)
    open_ = plan_run(rig, request(content("jog", joint="rotary", by="5 deg"), HOME, repeat=2))
    assert [s.name for s in open_.segments] == ["move 1", "return", "move 1, pass 2", "return, pass 2"]
    assert open_.program.at(open_.program.duration_s, 3)[0] == pytest.approx(HOME)
    assert "repeat must be at least 1" in _refusal(rig, request(paper_y30, repeat=0))


@pytest.mark.slow
def test_planning_of_long_runs_is_bounded(rig: Rig, paper_y30: dict[str, Any]) -> None:
    hour = content("sine_sweep", joint="rotary", amplitude=0.01, **{"from": 0.1, "to": 4.9}, duration=3600)
    plan_run(rig, request(hour, HOME))
    assert "too long for the shaper adaptive" in _refusal(rig, request(hour, HOME, {"kind": "adaptive"}))
    repeated = plan_run(rig, request(paper_y30, shaper={"kind": "adaptive"}, repeat=100))
    assert repeated.duration_s == pytest.approx(1830.0)
    fast = content("sine_sweep", joint="rotary", amplitude=0.01, **{"from": 0.1, "to": 5.4}, duration=3600)
    assert "rotary acceleration" in _refusal(rig, request(fast, HOME))


def test_joint_maneuver_with_its_own_start(rig: Rig) -> None:
    steps = content("joint_steps", start={"rotary": "10 deg"}, steps=[{"joint": "rotary", "to": "12 deg", "hold": 1.0}])
    assert "not at the start" in _refusal(rig, request(steps, HOME))
    plan = plan_run(rig, request(steps, HOME, approach=True))
    assert plan.program.at(plan.program.duration_s, 3)[0] == pytest.approx((radians(12), 0.9144))
    assert "one value for every joint" in _refusal(rig, request(steps))


def test_an_arm_outside_its_travel_can_be_jogged_back_only(rig: Rig) -> None:
    outside = [0.0, 0.3040]
    plan_run(rig, request(content("jog", joint="prismatic", by="10 mm"), outside))
    assert "below the limit" in _refusal(rig, request(content("jog", joint="prismatic", by="-1 mm"), outside))
    assert "below the limit" in _refusal(rig, request(content("staircase", joint="rotary", step="1 deg"), outside))


def test_request_survives_json_and_plan_survives_pickling(rig: Rig, paper_y30: dict[str, Any]) -> None:
    asked = request(paper_y30, [0.1 + 0.2 - 0.3, 0.762], {"kind": "adaptive", "joints": ["rotary", "prismatic"]}, run=7)
    assert RunRequest.from_json(asked.as_json()) == asked
    plan = plan_run(rig, asked)
    copy = pickle.loads(pickle.dumps(plan))
    for t in (0.0, 1.2345, 9.0, 18.3):
        assert copy.program.at(t, copy.program.index_at(t)) == plan.program.at(t, plan.program.index_at(t))
    assert json.loads(json.dumps(plan.summary()))["segments"][5] == ["hold 3", "hold", pytest.approx(16.3), pytest.approx(18.3)]


@pytest.mark.parametrize("text", ["[1]", "{", '{"run": 1}', '{"run": 1, "maneuver": {}, "speed": 2}'])
def test_bad_requests_are_refused(text: str) -> None:
    with pytest.raises(ManeuverError):
        RunRequest.from_json(text)


def test_bad_maneuver_content_is_refused(rig: Rig, paper_y30: dict[str, Any]) -> None:
    assert "speed" in _refusal(rig, request(paper_y30 | {"speed": -1.0}))
