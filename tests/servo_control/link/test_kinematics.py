"""Straight line and trapezoid: closed forms of the reference, numerical derivatives, round trips."""

from __future__ import annotations

from math import degrees, pi, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.schema.rig import Rig
from servo_control.link.kinematics import forward, forward_rates, inverse, inverse_motion
from servo_control.path.trajectory import Trapezoid
from servo_control.planning.planning import plan_run
from tests.support.servo_control.testbed_runs import INCH, content, request

SPEED, ACCELERATION = 10 * INCH, 100 * INCH


def test_convention() -> None:
    """0 along +Y, positive anticlockwise: a quarter turn to the left is +90° and points along −X."""
    assert forward(0.0, 1.0) == pytest.approx((0.0, 1.0))
    assert forward(pi / 2, 1.0) == pytest.approx((-1.0, 0.0))
    assert inverse(-1.0, 0.0) == pytest.approx((pi / 2, 1.0))


@given(st.floats(-3, 3), st.floats(0.05, 5), st.floats(0, 1))
def test_round_trip(rotary: float, extension: float, hub_offset: float) -> None:
    assert inverse(*forward(rotary, extension, hub_offset), hub_offset) == pytest.approx((rotary, extension), abs=1e-9)


@given(st.floats(-2, 2), st.floats(0.2, 2), st.floats(-1, 1), st.floats(-5, 5), st.floats(0, 0.5))
def test_joint_motion_along_x_is_the_printed_one(x: float, y0: float, speed: float, acceleration: float, hub_offset: float) -> None:
    """q̇_p = ẋ cos q_r, q̇_r = −ẋ sin q_r/r, q̈_p = ẍ cos q_r + r q̇_r², q̈_r = −(ẍ sin q_r + 2 q̇_p q̇_r)/r."""
    motion = inverse_motion((x, y0), (speed, 0.0), (acceleration, 0.0), hub_offset)
    r, q_r = np.hypot(x, y0), np.arctan2(y0, x)
    q_p_rate, q_r_rate = speed * np.cos(q_r), -speed * np.sin(q_r) / r
    assert motion.position == pytest.approx((q_r - pi / 2, r - hub_offset), abs=1e-12)
    assert motion.rate == pytest.approx((q_r_rate, q_p_rate), abs=1e-12)
    expected = -(acceleration * np.sin(q_r) + 2 * q_p_rate * q_r_rate) / r, acceleration * np.cos(q_r) + r * q_r_rate**2
    assert motion.acceleration == pytest.approx(expected, abs=1e-9)
    assert forward_rates(motion.position, motion.rate, hub_offset) == pytest.approx((speed, 0.0), abs=1e-12)


@given(st.floats(-5, 5), st.floats(0.01, 3), st.floats(0.05, 30))
def test_trapezoid_is_exact_and_fastest(distance: float, speed: float, acceleration: float) -> None:
    profile = Trapezoid(distance, speed, acceleration)
    length = abs(distance)
    short = length < speed**2 / acceleration
    assert profile.duration_s == pytest.approx(2 * sqrt(length / acceleration) if short else length / speed + speed / acceleration)
    times = np.linspace(0, profile.duration_s, 2001)
    s, v, a = np.array([profile.at(t) for t in times]).T
    assert abs(v).max() <= speed * (1 + 1e-12)
    assert abs(a).max() <= acceleration * (1 + 1e-12)
    assert (s[0], s[-1], v[-1], a[-1]) == pytest.approx((0.0, distance, 0.0, 0.0))
    ramps = 2 * acceleration * (times[1] - times[0])
    assert np.diff(s) == pytest.approx((v[1:] + v[:-1]) / 2 * np.diff(times), abs=1e-12 + ramps * (times[1] - times[0]))


def test_paper_line_takes_16_3_s(rig: Rig, paper_y30: dict[str, Any]) -> None:
    """Row 17."""
    plan = plan_run(rig, request(paper_y30))
    assert [s.end_s for s in plan.segments if s.kind == "move"] == pytest.approx([3.1, 11.2, 16.3], abs=1e-12)
    assert plan.motion_end_s == pytest.approx(16.3, abs=1e-12)
    samples = [plan.program.at(t, plan.program.index_at(t)) for t in np.arange(0, 16300) * 1e-3]
    points = np.array([forward(*positions) for positions, *_ in samples])
    velocities = np.array([forward_rates(positions, rates) for positions, rates, *_ in samples])
    assert points[:, 1] == pytest.approx(30 * INCH, abs=1e-12)
    assert (points[:, 0].min(), points[:, 0].max()) == pytest.approx((-30 * INCH, 30 * INCH), abs=1e-12)
    assert np.hypot(*velocities.T).max() <= SPEED * (1 + 1e-12)
    assert abs(np.diff(velocities[:, 0])).max() <= ACCELERATION * 1e-3 * (1 + 1e-9)


# y0 in → L from, to (in), θ ± deg, θ̇ rad/s, θ̈ rad/s², q̇_p in/s
TABLE = {
    12: (12, 32.3, 68.2, 0.833, 8.33, 9.26),
    20: (20, 36.1, 56.3, 0.500, 5.00, 8.28),
    24: (24, 38.4, 51.3, 0.417, 4.17, 7.76),
    30: (30, 42.4, 45.0, 0.333, 3.33, 7.01),
    36: (36, 46.9, 39.8, 0.278, 2.78, 6.34),
    40: (40, 50.0, 36.9, 0.250, 2.50, 5.93),
    50: (50, 58.3, 31.0, 0.200, 2.00, 5.08),
}


@pytest.mark.parametrize("y0", TABLE)
def test_joint_demands_of_the_line(rig: Rig, y0: int) -> None:
    """Row 18, to the table's 0.5 %. A joint's largest speed is taken at cruise; the ramp at the end of the line is not counted there."""
    line = content("straight_line", y0=y0 * INCH, moves=[30 * INCH, -60 * INCH, 30 * INCH], speed=SPEED, acceleration=ACCELERATION)
    plan = plan_run(rig, request(line))
    rotary, prismatic = plan.peaks
    shortest, longest, swing, rate, acceleration, extension_rate = TABLE[y0]
    assert (prismatic.lowest / INCH, prismatic.highest / INCH) == pytest.approx((shortest, longest), rel=0.005)
    assert degrees(rotary.highest) == degrees(-rotary.lowest) == pytest.approx(swing, rel=0.005)
    assert rotary.rate == pytest.approx(rate, rel=0.005)
    assert rotary.acceleration == pytest.approx(acceleration, rel=0.005)
    assert prismatic.rate / INCH == pytest.approx(extension_rate, rel=0.005)
