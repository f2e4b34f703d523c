"""An arm whose link leaves its bearing 0.2 m before the hub axis: every room reckons from the axis, r = a + L.

The shipped arms have a = 0. The plane here is written down anew: the link lies on the ray at the angle p from the y axis.
"""

from __future__ import annotations

from math import cos, hypot, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest

from config.checking.actuator_sizes import actuator_sizes
from config.checking.check import feasible_y0
from config.errors import ManeuverError
from config.loading.load import apply_overrides, load_rig, rig_from_text
from daemon.checks.interlocks import rig_facts
from daemon.cycle.timing import WORDS, Timing
from daemon.live.page.planning import planned
from daemon.server.event_history import EventHistory
from daemon.server.status import StatusView
from servo_control.planning.mending import mended
from servo_control.planning.planning import plan_run
from servo_control.signals import Wanted
from tests.support.servo_control.hand_driven import hand_driven, stream_plan
from tests.support.servo_control.testbed_runs import INCH, content, request, shipped

A, HALF = 0.2, 30 * INCH
TEXT = apply_overrides(load_rig("ornl_testbed").text, [f"arm.hub_offset={A} m"])
RIG = rig_from_text(TEXT)
SHORTEST, LONGEST = A + 12 * INCH, A + 60 * INCH
NEAREST_Y0, FARTHEST_Y0 = SHORTEST, sqrt(LONGEST**2 - HALF**2)  # of a line from -30 to 30 in


def place(rotary: float, extension: float) -> tuple[float, float]:
    return -(A + extension) * sin(rotary), (A + extension) * cos(rotary)


def line(y0_m: float, **more: Any) -> dict[str, Any]:
    rest = {"moves": [HALF, -2 * HALF, HALF], "speed": 5 * INCH, "acceleration": 50 * INCH}
    return content("straight_line", y0=y0_m, **(rest | more))


def test_a_line_is_straight_and_as_long_as_asked() -> None:
    plan = plan_run(RIG, request(shipped("paper_line_y30")))
    moments = np.linspace(0.0, plan.program.duration_s, 400)
    tip = np.array([place(*plan.program.at(t, plan.program.index_at(t))[0]) for t in moments])
    assert tip[:, 1] == pytest.approx(30 * INCH, abs=1e-12)
    assert (tip[:, 0].min(), tip[:, 0].max()) == pytest.approx((-HALF, HALF), abs=1e-3)


def test_lines_are_allowed_from_the_shortest_to_the_longest_radius() -> None:
    assert feasible_y0(RIG, HALF) == pytest.approx((NEAREST_Y0, FARTHEST_Y0))
    for y0_m in (NEAREST_Y0 + 1e-6, FARTHEST_Y0 - 1e-6):
        plan_run(RIG, request(line(y0_m)))
    advice = f"Choose y0 ≥ {NEAREST_Y0:.4f} m and y0 ≤ {FARTHEST_Y0:.4f} m."
    for y0_m in (NEAREST_Y0 - 1e-6, FARTHEST_Y0 + 1e-6):
        with pytest.raises(ManeuverError) as refused:
            plan_run(RIG, request(line(y0_m)))
        assert advice in str(refused.value)


def test_a_line_out_of_reach_is_mended_to_the_nearest_that_fits() -> None:
    near, far = (float(mended(RIG, request(line(y0_m)))["y0"].split()[0]) for y0_m in (0.1, 3.0))
    assert NEAREST_Y0 < near < 1.003 * NEAREST_Y0
    assert 0.997 * FARTHEST_Y0 < far < FARTHEST_Y0


def test_a_line_too_fast_for_the_tips_interlock_is_mended_by_the_acceleration_that_the_tip_has() -> None:
    """It begins at right angles to the link, with all of its own acceleration across it."""
    strict = RIG.model_copy(update={"interlocks": RIG.interlocks.model_copy(update={"tip_acceleration_max_m_per_s2": 1.0})})
    told = float(mended(strict, request(line(1.0)))["acceleration"].split()[0])
    assert 0.99 < told < 1.0


def test_the_tip_of_a_turning_arm_has_the_speed_and_acceleration_of_its_radius() -> None:
    radius, start = A + 0.9, [0.3, 0.9]
    plan = plan_run(RIG, request(content("jog", joint="rotary", by="20 deg", speed="0.5 rad/s"), start))
    assert plan.tip is not None
    assert plan.tip.speed_mps == pytest.approx(radius * 0.5)
    assert plan.tip.acceleration_mps2 == pytest.approx(radius * plan.peaks[0].acceleration)


def test_a_tip_driven_by_hand_goes_straight_in_the_direction_it_is_sent() -> None:
    driven = hand_driven(RIG, (0.2, 1.0), {"kind": "none"})
    driven.drive(Wanted.TIP, (0.05, 0.0), 2000)
    tip = np.array([place(*target) for target in driven.target])
    x, y = place(0.2, 1.0)
    assert tip[:, 1] == pytest.approx(y, abs=1e-4)
    assert np.diff(tip[-500:, 0]) == pytest.approx(0.05e-3, rel=1e-3)
    assert tip[-1, 0] == pytest.approx(x + 0.05 * 2.0, abs=0.01)


def test_the_fastest_tip_by_hand_is_both_joints_at_their_limits_far_out() -> None:
    assert stream_plan(RIG).tip_speed_mps == pytest.approx(hypot(12 * INCH, LONGEST * 60 * pi / 180))


def test_status_and_page_show_the_tip_where_it_is() -> None:
    facts = rig_facts(RIG)
    values = facts.blank()
    values[facts.index("rotary.position")], values[facts.index("prismatic.position")] = 0.4, 0.9
    tip = StatusView(RIG, facts, Timing([0] * WORDS)).status(values, 0.0, EventHistory())["tip"]
    assert (tip["x_m"], tip["y_m"]) == pytest.approx(place(0.4, 0.9))
    path = planned(TEXT, {"maneuver": {"name": "paper_line_y30"}}, [0.0, 30 * INCH - A])["path"]
    assert [y for _, y in path] == pytest.approx([30 * INCH] * len(path), abs=1e-12)


def test_what_the_rotary_actuator_turns_is_reckoned_about_the_axis() -> None:
    """Parallel axes: the tube's centre lies half its length behind the tip, the payload at the tip."""
    sizes, plant = actuator_sizes(RIG, "rotary"), RIG.plant
    assert sizes is not None
    assert plant is not None
    assert plant.link is not None
    link, reach = plant.link, A + 36 * INCH
    tube_kg, length = link.mass_per_length_kg_per_m * link.total_length_m, link.total_length_m
    tube = tube_kg * (length**2 / 12 + (reach - length / 2) ** 2)
    assert sizes.mass == pytest.approx(tube + link.payload_kg * reach**2 + link.hub_inertia_kg_m2 + link.payload_inertia_kg_m2)
