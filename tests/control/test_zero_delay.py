"""Shaping within the move: splines in closed form, an undamped oscillator's residual by quadrature, straightness, duration, replay."""

from __future__ import annotations

import json
from math import hypot, sin

import numpy as np
import pytest
from asking import INCH, content, request, shipped
from scipy.interpolate import BSpline

from config.errors import ManeuverError
from config.load import load_rig
from config.rig import LinkMode, Rig
from control.controller import Controller
from control.corrected_path import CorrectedPath, bump
from control.kinematics import forward
from control.link_mode import LinkFrequency
from control.link_motion import carried_arm
from control.planning import plan_run
from control.signals import Inputs, Mode
from control.trajectory import Trapezoid
from control.zero_delay import corrected

UNDAMPED = LinkMode(bending_stiffness=3556.75, mass_per_length=2.545698, payload=20.41, damping_ratio=0.0)
LENGTH = 1.0
HOME = [0.0, 40 * INCH]


def _residual(path: Trapezoid | CorrectedPath, scale: float) -> float:
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


@pytest.mark.parametrize("share", [0.0, 0.1])
def test_no_residual_over_the_range_and_no_delay(share: float) -> None:
    path = Trapezoid(0.6, 0.3, 3.0)
    found = corrected(path, lambda s: (s, LENGTH), UNDAMPED, 1.0, share)
    before = max(_residual(path, scale) for scale in (0.95, 1.0, 1.05))
    assert before > 1.0
    for scale in np.linspace(1.0 - share, 1.0 + share, 9):
        assert _residual(found, float(scale)) < 0.04 * before
    assert found.duration_s == path.duration_s
    assert found.at(path.duration_s) == path.at(path.duration_s) == (0.6, 0.0, 0.0)
    assert found.at(0.0) == path.at(0.0)


def test_the_correction_is_the_least_one() -> None:
    """∫δs̈² against the minimum-norm solution for a constant length, from the same two conditions by numpy."""
    path = Trapezoid(0.6, 0.3, 3.0)
    found = corrected(path, lambda s: (s, LENGTH), UNDAMPED, 1.0, 0.0)
    omega, step = LinkFrequency(UNDAMPED).omega_d(LENGTH), path.duration_s / 20000
    t = (np.arange(20000) + 0.5) * step
    extra = np.array([found.at(float(x))[2] - path.at(float(x))[2] for x in t])
    # without the limit to splines the least one is a combination of sin and cos: nearly reached
    basis = np.array([np.cos(omega * t), np.sin(omega * t), np.ones_like(t), t])
    wanted = basis @ extra * step
    least = float(wanted @ np.linalg.solve(basis @ basis.T * step, wanted))
    assert np.sum(extra**2) * step < 1.1 * least


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


def test_the_mode_of_the_corrected_line_ends_at_rest() -> None:
    """Independent of the adjoint: the mode driven by the planned joints, integrated with small steps and the joint's acceleration."""
    rig = _line_rig()
    plan = plan_run(rig, request(shipped("paper_line"), HOME, {"kind": "zero_delay"}))
    assert rig.link_mode is not None
    mode = LinkFrequency(rig.link_mode)
    w = speed = 0.0
    step = 0.00025
    for n in range(round(3.1 / step)):
        (_, length), (rate, length_rate), (acceleration, _), _ = plan.program.at((n + 0.5) * step, 0)
        omega = mode.omega_d(length)
        forced = -carried_arm(rig.link_mode, length) * acceleration - 2.0 * length_rate * rate
        speed += step * (forced - omega**2 * w - 2 * mode.damping_ratio * omega * speed)
        w += step * speed
    omega = mode.omega_d(length)
    assert omega * hypot(omega * w, speed) < 0.06
