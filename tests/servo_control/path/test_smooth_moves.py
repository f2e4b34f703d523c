"""Half a cycle of filter under ramps without corners: closed forms of the ramp and of the filter, what is kept of a move, limits, pace."""

from __future__ import annotations

from math import cos, pi
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from config.errors import ManeuverError
from config.loading.load import load_rig
from config.schema.rig import LinkMode, Rig
from servo_control.link.link_mode import LinkFrequency
from servo_control.path.smooth_moves import FASTER
from servo_control.path.trajectory import SmoothRamps, Trapezoid, smoothed
from servo_control.planning.planning import plan_run
from servo_control.planning.prediction import predict
from servo_control.shapers.impulses import residual_vibration, zv
from servo_control.shapers.phase_shaper import PhaseShaper
from tests.support.servo_control.testbed_runs import INCH, content, request, shipped

BOTH_JOINTS: dict[str, Any] = {"kind": "adaptive_zv", "joints": ["rotary", "prismatic"]}
LINES = [("paper_line", 40 * INCH), ("paper_line_y30", 30 * INCH)]
PERIOD_S = 0.001
UNDAMPED = LinkMode(bending_stiffness=3556.75, mass_per_length=2.545698, payload=20.41, damping_ratio=0.0)


def test_the_ramps_are_as_long_as_the_higher_speed_allows() -> None:
    """Same duration T and distance d: d = f v (T − r), so r = T − d/(f v); 0.79 s for 30 in at 10 in/s, which is two cycles at 50 in."""
    path = smoothed(Trapezoid(0.762, 0.254, 2.54), FASTER)
    assert isinstance(path, SmoothRamps)
    assert path.duration_s == pytest.approx(3.1)
    assert path.ramp_s == pytest.approx(3.1 - 3.0 / FASTER)
    assert path.at(1.55)[1] == pytest.approx(FASTER * 0.254)
    assert path.at(path.duration_s)[0] == 0.762


@pytest.mark.parametrize("wrong", [0.8, 1.0, 1.2])
def test_half_a_cycle_leaves_what_theory_says(wrong: float) -> None:
    """Undamped and at one extension: the transform of the reference's rate at the link's frequency is cos(π/2 · true/believed) times that
    of the target's. 31 % at a frequency believed 20 % too high or too low."""
    believed = LinkFrequency(UNDAMPED)
    omega = wrong * believed.omega_d(1.0)
    shaper = PhaseShaper(believed, zv(1.0, 0.0)[0], (0,), 1, (0.3, 1.5), PERIOD_S)
    shaper.reset([0.0, 1.0])
    path = Trapezoid(0.6, 0.3, 3.0)
    rows = []
    for n in range(4000):
        s, rate, _ = path.at(n * PERIOD_S)
        reference, reference_rate = [0.0, 0.0], [0.0, 0.0]
        shaper.step([s, 1.0], [rate, 0.0], reference, reference_rate)
        rows.append((rate, reference_rate[0]))
    turning = np.exp(-1j * omega * PERIOD_S * np.arange(len(rows)))
    target, shaped = np.abs(turning @ np.array(rows))
    assert shaped / target == pytest.approx(abs(cos(0.5 * pi * wrong)), abs=1e-3)
    assert residual_vibration(zv(1.0, 0.0), wrong, 0.0) == pytest.approx(shaped / target, abs=1e-3)


def test_the_phase_domain_emits_after_half_a_cycle_only(rig: Rig) -> None:
    """Rotary only: the phase is that of the target extension, integrated and inverted here by numpy."""
    cycles = list(predict(rig, plan_run(rig, request(shipped("paper_line_y30"), shaper={"kind": "adaptive_zv"}))))
    target, reference = (np.array([getattr(cycle, name) for cycle in cycles]) for name in ("target", "reference"))
    assert rig.link_mode is not None
    omega = np.array([LinkFrequency(rig.link_mode).omega_d(x) for x in target[:, 1]])
    t = np.arange(len(target)) * PERIOD_S
    phase = cumulative_trapezoid(omega, t, initial=0.0)
    k = np.exp(-np.pi * 0.005 / np.sqrt(1 - 0.005**2))
    expected = (target[:, 0] + k * np.interp(np.interp(phase - np.pi, phase, t, left=0.0), t, target[:, 0])) / (1 + k)
    assert reference[:, 0] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("line", "y0"), LINES)
def test_the_references_are_at_rest_less_than_0_3_s_after_the_planned_end(rig: Rig, line: str, y0: float) -> None:
    """45 lb, both joints: half a period of the link, 0.20 s at 50 in, 0.155 at 42 in, and no longer program."""
    plan = plan_run(rig, request(shipped(line), [0.0, y0], BOTH_JOINTS))
    plain = plan_run(rig, request(shipped(line), [0.0, y0]))
    assert plan.program.duration_s == plain.program.duration_s
    reference = np.array([cycle.reference for cycle in predict(rig, plan)])
    for segment in (segment for segment in plan.segments if segment.kind == "move"):
        end = round(segment.end_s / PERIOD_S)
        still = reference[end + round(1.0 / PERIOD_S)]
        late = np.flatnonzero(np.any(np.abs(reference[end:][:1000] - still) > 1e-9, axis=1))
        assert 0.07 < late[-1] * PERIOD_S < 0.21


def test_only_moves_are_changed(rig: Rig) -> None:
    """Holds are where they were, moves begin and end there and are faster in between; nothing jumps in acceleration."""
    plain, plan = (plan_run(rig, request(shipped("paper_line"), shaper={"kind": kind})) for kind in ("none", "adaptive_zv"))
    assert [(s.name, s.start_s, s.end_s) for s in plan.segments] == [(s.name, s.start_s, s.end_s) for s in plain.segments]
    for segment in plan.segments:
        for t in (segment.start_s, segment.end_s):
            found, expected = (p.program.at(t, p.program.index_at(t))[0] for p in (plan, plain))
            assert found == pytest.approx(expected, abs=1e-12)
    steps = {}
    for name, each in (("plain", plain), ("smooth", plan)):
        acceleration = [each.program.at(t, 0)[2][0] for t in np.arange(0.0, 3.1, PERIOD_S)]
        steps[name] = float(np.abs(np.diff(acceleration)).max())
    assert steps["smooth"] < 0.01 < 0.5 < steps["plain"]


def test_a_move_of_no_distance_and_a_short_one_keep_their_time_law(rig: Rig) -> None:
    for by in ("0 in", "1 in"):
        jog = content("jog", joint="prismatic", by=by)
        shaped, plain = (plan_run(rig, request(jog, [0.0, 40 * INCH], {"kind": kind})) for kind in ("adaptive_zv", "none"))
        assert shaped.program.at(0.4, 0) == plain.program.at(0.4, 0)


def test_a_line_that_smooth_ramps_make_too_fast_is_told_its_pace(rig: Rig) -> None:
    """At y0 = 12 in the prismatic joint needs 9.26 in/s of its 12, with smooth ramps 1.3 times as much."""
    line = shipped("paper_line") | {"y0": 12 * INCH}
    plan_run(rig, request(line))
    with pytest.raises(ManeuverError, match=r"at 0\.9 of its pace: speed 0\.2286 m/s, acceleration 2\.286 m/s\^2"):
        plan_run(rig, request(line, shaper=BOTH_JOINTS))
    plan_run(rig, request(line | {"speed": 0.2286, "acceleration": 2.286}, shaper=BOTH_JOINTS))


def test_an_arm_without_link_is_refused() -> None:
    axis = load_rig("force_axis").rig
    with pytest.raises(ManeuverError, match="an adaptive shaper needs"):
        plan_run(axis, request(content("jog", joint="axis", by="10 mm"), [0.0], {"kind": "adaptive_zv"}))
