"""Whatever is sent, the arm stays within travel, rate and acceleration, target and reference; and it gets where it is sent."""

from __future__ import annotations

import json
from itertools import pairwise
from math import inf, nan
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.link.kinematics import forward, forward_rates, joint_rates
from servo_control.signals import SetPoint, Wanted
from servo_control.streaming.stream_plan import FILTERS
from tests.support.servo_control.hand_driven import HandDriven, hand_driven, stream_plan

PERIOD_S = 0.001
BOTH = ["rotary", "prismatic"]
SHAPERS: list[dict[str, Any]] = [{"kind": "none"}, *({"kind": kind, "joints": BOTH} for kind in ("zvd", "adaptive", "adaptive_zv"))]
ANY = st.one_of(st.floats(-2.0, 2.0), st.sampled_from([nan, inf, -inf, 1e300, 0.0]))
INSIDE = st.tuples(st.floats(-1.04, 1.04), st.floats(-0.3, 0.3))
POINTS = st.one_of(
    st.builds(lambda values: SetPoint(1, Wanted.RATE, values, 0.0), INSIDE),
    st.builds(lambda a, b: SetPoint(1, Wanted.TARGET, (a, b), 0.0), st.floats(-1.5, 1.5), st.floats(0.31, 1.52)),
    st.builds(lambda x, y: SetPoint(1, Wanted.TIP, (x, y), 0.0), st.floats(-1.1, 1.1), st.floats(-1.1, 1.1)),
    st.builds(lambda a, b, late: SetPoint(1, Wanted.RATE, (a, b), late), ANY, ANY, st.floats(0.0, 1.0)),
    st.builds(lambda values: SetPoint(2, Wanted.RATE, values, 0.0), INSIDE),
    st.none(),
)
STREAMS = st.lists(st.tuples(POINTS, st.integers(1, 120)), min_size=1, max_size=8)
STARTS = st.tuples(st.floats(-1.53, 1.53), st.floats(0.305, 1.523))


def run(rig: Rig, stream: list[tuple[SetPoint | None, int]], start: tuple[float, float], shaper: dict[str, Any]) -> HandDriven:
    driven = hand_driven(rig, start, shaper)
    for point, cycles in stream:
        driven.cycle(point)
        for _ in range(cycles - 1):
            driven.cycle()
    driven.until_done(stop=True)
    return driven


@pytest.mark.parametrize("shaper", SHAPERS, ids=lambda shaper: shaper["kind"])
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(stream=STREAMS, start=STARTS)
@example(stream=[(SetPoint(1, Wanted.RATE, (1.0, 0.0), 0.0), 26)], start=(0.0, 0.3125))
def test_any_stream_keeps_within_all_limits(
    rig: Rig, shaper: dict[str, Any], stream: list[tuple[SetPoint | None, int]], start: tuple[float, float]
) -> None:
    driven = run(rig, stream, start, shaper)
    for j, joint in enumerate(rig.joints.values()):
        low, high = joint.travel
        for rows in (driven.target, driven.reference):
            position = np.array([start[j], *(row[j] for row in rows)])
            assert np.all(position >= low - 1e-12)
            assert np.all(position <= high + 1e-12)
            assert np.max(np.abs(np.diff(position))) <= joint.rate_limit * PERIOD_S * (1.0 + 1e-6)
        for rows in (driven.target_rate, driven.reference_rate):
            rate = np.array([0.0, *(row[j] for row in rows)])
            assert np.max(np.abs(np.diff(rate))) <= joint.acceleration_limit * PERIOD_S * (1.0 + 1e-6)
            assert rate[-1] == pytest.approx(0.0, abs=1e-12)
        target = np.array([start[j], *(row[j] for row in driven.target)])
        assert np.diff(target) / PERIOD_S == pytest.approx(np.array([row[j] for row in driven.target_rate]), abs=1e-9)
    assert driven.reference[-1] == pytest.approx(driven.target[-1], abs=1e-9)


@pytest.mark.parametrize("outward", [1.0, -1.0])
def test_a_joint_sent_to_its_end_stops_exactly_there_without_a_jolt(rig: Rig, outward: float) -> None:
    driven = hand_driven(rig, shaper={"kind": "none"})
    driven.drive(Wanted.RATE, (outward * 1.0, 0.0), 3000)
    low, high = rig.joints["rotary"].travel
    assert driven.target[-1][0] == pytest.approx(high if outward > 0.0 else low, abs=1e-12)
    assert driven.target_rate[-1][0] == 0.0


@pytest.mark.parametrize("goal", [(0.4, 1.2), (-1.5, 0.31), (0.0, 1.0), (1e-7, 1.0 - 1e-9)])
def test_a_target_is_reached_exactly_and_held(rig: Rig, goal: tuple[float, float]) -> None:
    driven = hand_driven(rig, shaper={"kind": "none"})
    driven.drive(Wanted.TARGET, goal, 6000)
    assert driven.target[-1] == pytest.approx(list(goal), abs=1e-12)
    assert driven.target_rate[-1] == [0.0, 0.0]
    overshoot = [max(0.0, abs(row[j] - start) - abs(goal[j] - start)) for row in driven.target for j, start in enumerate((0.0, 1.0))]
    assert max(overshoot) <= 1e-12


def test_the_tip_goes_straight_and_stops_on_its_line_where_a_joint_ends(rig: Rig) -> None:
    driven = hand_driven(rig, start=(0.0, 0.762), shaper={"kind": "none"})
    driven.drive(Wanted.TIP, (0.25, 0.0), 8000)
    points = np.array([forward(*row) for row in driven.target])
    assert points[:, 1] == pytest.approx(0.762, abs=2e-4)  # of 1.3 m of way
    assert np.all(np.diff(points[:, 0]) >= -1e-15)
    assert driven.target[-1][1] == pytest.approx(rig.joints["prismatic"].travel[1], abs=1e-6)  # the link is all out
    assert driven.target_rate[-1] == pytest.approx([0.0, 0.0], abs=1e-9)


@given(rotary=st.floats(-1.5, 1.5), extension=st.floats(0.31, 1.5), x=st.floats(-1.0, 1.0), y=st.floats(-1.0, 1.0))
def test_joint_rates_of_the_tip_are_the_inverse_of_its_velocity(rotary: float, extension: float, x: float, y: float) -> None:
    place = (rotary, extension)
    assert forward_rates(place, joint_rates(place, (x, y), 0.1), 0.1) == pytest.approx((x, y), abs=1e-12)


def test_an_arm_outside_its_travel_comes_back_and_goes_no_farther(rig: Rig) -> None:
    outside = rig.joints["rotary"].travel[1] + 0.02
    driven = hand_driven(rig, start=(outside, 1.0), shaper={"kind": "none"})
    driven.drive(Wanted.RATE, (0.5, 0.0), 500)
    assert {row[0] for row in driven.target} == {outside}
    driven.drive(Wanted.RATE, (-0.5, 0.0), 500)
    assert driven.target[-1][0] < outside - 0.1


@pytest.mark.parametrize(
    ("point", "what"),
    [
        (SetPoint(1, Wanted.RATE, (nan, 0.0), 0.0), "unusable"),
        (SetPoint(1, Wanted.TIP, (inf, 0.0), 0.0), "unusable"),
        (SetPoint(1, Wanted.RATE, (1.1, 0.0), 0.0), "reach"),
        (SetPoint(1, Wanted.TARGET, (1.6, 1.0), 0.0), "reach"),
        (SetPoint(1, Wanted.TIP, (1.2, 1.2), 0.0), "reach"),
        (SetPoint(1, Wanted.RATE, (0.5, 0.0), 0.3), "late_s"),
        (SetPoint(1, Wanted.CLIENT_LEFT, (), 0.0), "client_left"),
    ],
)
def test_what_cannot_be_is_not_followed_and_stays_visible(rig: Rig, point: SetPoint, what: str) -> None:
    driven = hand_driven(rig, shaper={"kind": "none"})
    driven.drive(Wanted.RATE, (0.5, 0.0), 400)
    assert getattr(driven.motion.driving, what) <= (1.0 if what == "reach" else 0.0)
    driven.cycle(point)
    assert getattr(driven.motion.driving, what) > (1.0 if what == "reach" else 0.0)
    rates = [row[0] for row in driven.target_rate[-1:]]
    for _ in range(200):
        driven.cycle()
        rates.append(driven.target_rate[-1][0])
    assert all(later <= before for before, later in pairwise(rates))
    assert rates[-1] == 0.0
    assert getattr(driven.motion.driving, what) > (1.0 if what == "reach" else 0.0)


def test_silence_is_counted_from_the_last_set_point_of_this_run(rig: Rig) -> None:
    driven = hand_driven(rig)
    driven.cycle(SetPoint(1, Wanted.RATE, (0.1, 0.0), 0.0))
    assert driven.motion.driving.silent_s == 0.0
    for number in range(1, 200):
        driven.cycle(SetPoint(7, Wanted.RATE, (0.1, 0.0), 0.0) if number % 3 else None)
        assert driven.motion.driving.silent_s == pytest.approx(number * PERIOD_S)


def test_a_stop_takes_the_braking_time_and_the_filter(rig: Rig) -> None:
    driven = hand_driven(rig)
    driven.drive(Wanted.RATE, (0.5, 0.0), 1000)
    plan = driven.motion.plan
    expected_s = 0.5 / plan.accelerations[0] + plan.flush_s
    assert driven.until_done(stop=True) * PERIOD_S == pytest.approx(expected_s, abs=0.005)


def test_an_end_that_was_asked_for_is_no_silence(rig: Rig) -> None:
    driven = hand_driven(rig)
    driven.drive(Wanted.RATE, (0.5, 0.0), 300)
    driven.cycle(SetPoint(1, Wanted.END, (), 0.0))
    driven.until_done()
    assert driven.motion.driving.silent_s == 0.0


@pytest.mark.parametrize("kind", ["three_term", "notch", "robust_notch", "zero_delay", "adaptive_coefficients", "adaptive_delay"])
def test_filters_that_can_overshoot_or_look_ahead_are_refused(rig: Rig, kind: str) -> None:
    with pytest.raises(ManeuverError, match="cannot be used when driving by hand") as refused:
        stream_plan(rig, shaper={"kind": kind})
    assert refused.value.refusal.limit == ", ".join(FILTERS)


def test_the_target_leaves_the_filter_room(rig: Rig) -> None:
    plan = stream_plan(rig)
    for rate, acceleration, joint in zip(plan.rates, plan.accelerations, rig.joints.values(), strict=True):
        assert 0.85 * joint.rate_limit < rate < joint.rate_limit
        assert 0.6 * joint.acceleration_limit < acceleration < joint.acceleration_limit
    free = stream_plan(rig, shaper={"kind": "none"})
    assert free.rates == tuple(joint.rate_limit for joint in rig.joints.values())


@pytest.mark.parametrize("shaper", SHAPERS, ids=lambda shaper: shaper["kind"])
@pytest.mark.parametrize("moment", [0, 1, 137, 700])
def test_it_goes_on_from_a_snapshot_bit_for_bit(rig: Rig, shaper: dict[str, Any], moment: int) -> None:
    points = [
        SetPoint(1, Wanted.TIP, (0.2, 0.1), 0.0),
        SetPoint(1, Wanted.RATE, (-0.4, 0.1), 0.0),
        SetPoint(1, Wanted.TARGET, (0.1, 0.9), 0.0),
    ]

    def go_on(driven: HandDriven, first: int) -> None:
        for cycle in range(first, 1000):
            driven.cycle(points[cycle // 300 % 3] if cycle % 100 == 0 else None, stop=cycle > 900)

    whole, part = hand_driven(rig, shaper=shaper), hand_driven(rig, shaper=shaper)
    go_on(whole, 0)
    for cycle in range(moment):
        part.cycle(points[cycle // 300 % 3] if cycle % 100 == 0 else None)
    again = hand_driven(rig, shaper=shaper)
    again.motion.restore(json.loads(json.dumps(part.motion.snapshot())))
    go_on(again, moment)
    assert again.reference == whole.reference[moment:]
    assert again.target_rate == whole.target_rate[moment:]
    assert again.motion.driving == whole.motion.driving
