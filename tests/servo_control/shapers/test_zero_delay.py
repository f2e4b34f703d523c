"""Shaping within the move: splines in closed form, an undamped oscillator's residual by quadrature, straightness, duration, replay."""

from __future__ import annotations

import json
from math import hypot, sin

import numpy as np
import pytest
from scipy.interpolate import BSpline

from config.errors import ManeuverError
from config.loading.load import load_rig
from config.schema.rig import LinkMode, Rig
from servo_control.controller import Controller
from servo_control.link.kinematics import forward
from servo_control.link.link_mode import LinkFrequency
from servo_control.link.link_motion import carried_arm
from servo_control.path.corrected_path import CorrectedPath, bump
from servo_control.path.trajectory import SmoothRamps, Trapezoid, smoothed
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.shapers.zero_delay import FINENESS, corrected
from servo_control.signals import Inputs, Mode
from tests.support.servo_control.testbed_runs import INCH, content, request, shipped

UNDAMPED = LinkMode(bending_stiffness=3556.75, mass_per_length=2.545698, payload=20.41, damping_ratio=0.0)
LENGTH = 1.0
HOME = [0.0, 40 * INCH]
# Rotary (rad) and extension (m) at 0.3, 1.7, 2.9, 6 and 15 s of the line at y0 = 30 in, from the version before planning 2.
PLACES_OF_PLANNING_1 = [
    (-0.05942710350771145, 0.7633475150079548),
    (-0.5173742042811286, 0.8767479954063018),
    (-0.7755484147574325, 1.067171302163008),
    (-0.6556164958725165, 0.9613052760352992),
    (0.38052161266660584, 0.8207041182553938),
]


def _residual(path: Trapezoid | SmoothRamps | CorrectedPath, scale: float) -> float:
    """Acceleration amplitude (m/s²) that a rotation by s rad leaves on an undamped oscillator: α ω |∫ θ̈ e^{−jωt} dt|."""
    omega = LinkFrequency(UNDAMPED, scale).omega_d(LENGTH)
    t = np.linspace(0.0, path.duration_s, 40001)
    middle = 0.5 * (t[1:] + t[:-1])
    acceleration = np.array([path.at(float(x))[2] for x in middle])
    return float(carried_arm(UNDAMPED, LENGTH) * omega * abs(np.sum(acceleration * np.exp(-1j * omega * middle)) * (t[1] - t[0])))


def test_bump_is_the_cubic_b_spline() -> None:
    spline = BSpline.basis_element(np.arange(5.0), extrapolate=False)
    for x in np.linspace(0.01, 3.99, 57):
        expected = [float(spline.derivative(k)(x)) if k else float(spline(x)) for k in range(3)]
        assert bump(float(x)) == pytest.approx(expected, abs=1e-12)
    assert bump(-0.1) == bump(4.0) == (0.0, 0.0, 0.0)


def test_trapezoid_residual_has_its_closed_form() -> None:
    """Four ramps of the speed: |∫ θ̈ e^{−jωt}| = 4 (a/ω) sin(ω t_a/2) |sin(ω (T − t_a)/2)|: the quadrature used below is right."""
    path = Trapezoid(0.6, 0.3, 3.0)
    omega = LinkFrequency(UNDAMPED).omega_d(LENGTH)
    expected = 4.0 * 3.0 / omega * abs(sin(omega * 0.05) * sin(omega * (path.duration_s - 0.1) / 2.0)) * omega
    assert _residual(path, 1.0) == pytest.approx(carried_arm(UNDAMPED, LENGTH) * expected, rel=1e-3)


@pytest.mark.parametrize("planning", FINENESS)
@pytest.mark.parametrize("share", [0.0, 0.1])
def test_no_residual_over_the_range_and_no_delay(share: float, planning: int) -> None:
    path, faster = Trapezoid(0.6, 0.3, 3.0), FINENESS[planning].faster
    found = corrected(path, lambda s: (s, LENGTH), UNDAMPED, 1.0, share, FINENESS[planning])
    before = max(_residual(path, scale) for scale in (0.95, 1.0, 1.05))
    assert before > 1.0
    for scale in np.linspace(1.0 - share, 1.0 + share, 9):
        assert _residual(found, float(scale)) < 0.04 * before
    assert found.duration_s == path.duration_s
    assert found.at(path.duration_s) == path.at(path.duration_s) == (0.6, 0.0, 0.0)
    assert found.at(0.0) == (smoothed(path, faster) if faster else path).at(0.0)


@pytest.mark.parametrize("planning", FINENESS)
def test_the_correction_is_the_least_one(planning: int) -> None:
    """∫δs̈² against the minimum-norm solution for a constant length, from the same two conditions by numpy."""
    fineness = FINENESS[planning]
    planned = Trapezoid(0.6, 0.3, 3.0)
    path = smoothed(planned, fineness.faster) if fineness.faster else planned
    found = corrected(planned, lambda s: (s, LENGTH), UNDAMPED, 1.0, 0.0, fineness)
    omega, step = LinkFrequency(UNDAMPED).omega_d(LENGTH), path.duration_s / 20000
    t = (np.arange(20000) + 0.5) * step
    extra = np.array([found.at(float(x))[2] - path.at(float(x))[2] for x in t])
    # without the limit to splines the least one is a combination of sin and cos: nearly reached
    basis = np.array([np.cos(omega * t), np.sin(omega * t), np.ones_like(t), t])
    wanted = basis @ extra * step
    least = float(wanted @ np.linalg.solve(basis @ basis.T * step, wanted))
    assert np.sum(extra**2) * step < 1.1 * least


def test_smooth_ramps_have_the_slopes_they_give_and_no_corner() -> None:
    """Position, speed and acceleration against differences; nowhere more than the trapezoid's acceleration, 1.15 of its speed."""
    planned = Trapezoid(-0.762, 0.254, 2.54)
    path = smoothed(planned, 1.15)
    assert isinstance(path, SmoothRamps)
    assert (path.distance, path.duration_s) == (planned.distance, planned.duration_s)
    t = np.linspace(-0.01, path.duration_s + 0.01, 20001)
    s, speed, acceleration = np.array([path.at(float(x)) for x in t]).T
    assert (s[0], s[-1]) == (0.0, -0.762)
    assert np.gradient(s, t) == pytest.approx(speed, abs=1e-5)
    assert np.gradient(speed, t) == pytest.approx(acceleration, abs=1e-3)
    assert np.abs(speed).max() == pytest.approx(1.15 * 0.254)
    assert np.abs(acceleration).max() < 2.54
    assert np.abs(np.diff(acceleration)).max() < 0.01


@pytest.mark.parametrize("distance", [0.02, 0.1])
def test_a_short_move_keeps_its_ramps(distance: float) -> None:
    """A triangle, and a trapezoid hardly longer: smooth ramps would have to be steeper."""
    path = Trapezoid(distance, 0.254, 2.54)
    assert smoothed(path, 1.15) is path


@pytest.mark.slow
@pytest.mark.parametrize("pounds", [0.0, 20.0])
def test_a_fast_link_ends_at_rest_too(pounds: float) -> None:
    """Judged by the mode driven by the joints, integrated with small steps: 8 to 37 Hz, ends of the move corrected by themselves."""
    rig = _line_rig()
    assert rig.link_mode is not None
    believed = rig.link_mode.model_copy(update={"payload_kg": pounds * 0.45359237})
    rig = rig.model_copy(update={"link_mode": believed})
    plan = plan_run(rig, request(shipped("paper_line_y30"), [0.0, 30 * INCH], {"kind": "zero_delay"}))
    assert max(_left(plan, believed, scale) for scale in (0.9, 1.0, 1.1)) < 0.05


def _left(plan: RunPlan, link: LinkMode, scale: float) -> float:
    """Acceleration amplitude (m/s²) of the mode at the end of the first move."""
    mode = LinkFrequency(link, scale)
    w = speed = 0.0
    step = 0.00025
    for n in range(round(3.1 / step)):
        (_, length), (rate, length_rate), (acceleration, _), _ = plan.program.at((n + 0.5) * step, 0)
        omega = mode.omega_d(length)
        forced = -carried_arm(link, length) * acceleration - 2.0 * length_rate * rate
        speed += step * (forced - omega**2 * w - 2 * mode.damping_ratio * omega * speed)
        w += step * speed
    return omega * hypot(omega * w, speed)


def _line_rig() -> Rig:
    return load_rig("ornl_testbed").rig


def test_the_line_stays_straight_and_takes_as_long() -> None:
    rig = _line_rig()
    plain = plan_run(rig, request(shipped("paper_line"), HOME))
    plan = plan_run(rig, request(shipped("paper_line"), HOME, {"kind": "zero_delay"}))
    assert plan.duration_s == plain.duration_s
    times = np.arange(0.0, plan.program.duration_s, 0.01)
    points = [forward(*plan.program.at(float(t), plan.program.index_at(float(t)))[0]) for t in times]
    assert np.ptp([y for _, y in points]) < 1e-9
    assert plan.program.at(3.1, plan.program.index_at(3.1))[0] == pytest.approx(plain.program.at(3.1, plain.program.index_at(3.1))[0])


@pytest.mark.slow
def test_planned_again_from_its_request_it_is_the_same_to_the_bit() -> None:
    rig, asked = _line_rig(), request(shipped("paper_line"), HOME, {"kind": "zero_delay"})
    one = Controller(rig)
    one.prepare(plan_run(rig, asked))
    rows = [Inputs(n, Mode.HOLDING if n < 3 else Mode.RUNNING, 1, (0.0, HOME[1]), 0.0, 0.0) for n in range(900)]
    for row in rows[:500]:
        one.step(row)
    two = Controller(rig)
    two.restore(json.loads(json.dumps(one.snapshot(), allow_nan=False)))
    for row in rows[500:]:
        assert one.step(row) == two.step(row)


def test_a_move_of_the_extension_alone_is_left_as_it_is() -> None:
    rig = _line_rig()
    jog = content("jog", joint="prismatic", by="2 in")
    shaped, plain = (plan_run(rig, request(jog, HOME, {"kind": kind})) for kind in ("zero_delay", "none"))
    assert shaped.program.at(0.4, 0) == plain.program.at(0.4, 0)


def test_refusals() -> None:
    rig = _line_rig()
    with pytest.raises(ManeuverError, match="always moves all joints"):
        plan_run(rig, request(shipped("paper_line"), HOME, {"kind": "zero_delay", "joints": ["rotary"]}))
    with pytest.raises(ManeuverError, match="frequency_range is out of range"):
        plan_run(rig, request(shipped("paper_line"), HOME, {"kind": "zero_delay", "frequency_range": 0.3}))
    axis = load_rig("force_axis").rig
    with pytest.raises(ManeuverError, match="zero_delay needs"):
        plan_run(axis, request(content("jog", joint="axis", by="10 mm"), [0.0], {"kind": "zero_delay"}))


def test_a_line_too_fast_to_be_corrected_is_told_its_pace() -> None:
    """Twice the paper's speed is within the joints' limits, but not with what the correction adds; at the pace named it is."""
    rig, line = _line_rig(), shipped("paper_line") | {"speed": 0.5}
    plan_run(rig, request(line, HOME))
    with pytest.raises(ManeuverError, match=r"at 0\.9 of its pace: speed 0\.45 m/s, acceleration 2\.286 m/s\^2"):
        plan_run(rig, request(line, HOME, {"kind": "zero_delay"}))
    plan_run(rig, request(line | {"speed": 0.45, "acceleration": 2.286}, HOME, {"kind": "zero_delay"}))


def test_the_mode_of_the_corrected_line_ends_at_rest() -> None:
    """Independent of the adjoint: the mode driven by the planned joints, integrated with small steps and the joint's acceleration."""
    rig = _line_rig()
    plan = plan_run(rig, request(shipped("paper_line"), HOME, {"kind": "zero_delay"}))
    assert rig.link_mode is not None
    assert _left(plan, rig.link_mode, 1.0) < 0.06


def test_a_request_of_an_earlier_version_is_planned_as_it_was() -> None:
    """Without the number of its planning: eighty splines at most, ramps with corners; the same places to 1e-12 as they were logged."""
    rig = _line_rig()
    asked = json.loads(request(shipped("paper_line_y30"), [0.0, 30 * INCH], {"kind": "zero_delay"}).as_json())
    del asked["planning"]
    plan = plan_run(rig, RunRequest.from_json(json.dumps(asked)))
    places = [plan.program.at(t, plan.program.index_at(t))[0] for t in (0.3, 1.7, 2.9, 6.0, 15.0)]
    assert np.array(places) == pytest.approx(np.array(PLACES_OF_PLANNING_1), abs=1e-12)
    assert RunRequest.from_json(plan.request.as_json()) == plan.request
    with pytest.raises(ManeuverError, match="another version"):
        RunRequest.from_json(json.dumps({**asked, "planning": 3}))
