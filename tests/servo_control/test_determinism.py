"""step is a function of its inputs and its state: same inputs, same outputs, bit for bit, also from a snapshot that went through JSON."""

from __future__ import annotations

import json
from dataclasses import astuple
from functools import cache
from math import isfinite, isnan, nan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config.loading.load import find, load_rig
from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.signals import Inputs, Mode, Outputs
from tests.support.servo_control.ideal_arm import IdealArm
from tests.support.servo_control.testbed_runs import INCH, request, shipped

HOME = [0.0, 30 * INCH]
OFF = (Mode.DISARMED, Mode.ARMING, Mode.FAULT, Mode.PROVING)


@cache
def _rig() -> Rig:
    return load_rig(find("rigs", "ornl_testbed")).rig


@cache
def _plan(kind: str) -> RunPlan:
    return plan_run(_rig(), request(shipped("paper_line_y30"), HOME, {"kind": kind, "joints": ["rotary", "prismatic"]}))


positions = st.one_of(st.floats(-2, 2), st.floats(allow_nan=True, allow_infinity=True))
stretches = st.lists(
    st.tuples(st.sampled_from(list(Mode)), st.integers(0, 2), st.integers(1, 60), positions, positions), min_size=1, max_size=12
)


def _inputs(plan: list[tuple[Mode, int, int, float, float]]) -> list[Inputs]:
    """The positions serve as tip signals as well: any numbers there, too."""
    rows = [(mode, run, (a, b)) for mode, run, cycles, a, b in plan for _ in range(cycles)]
    return [Inputs(n, mode, run, position, position[1], position[0]) for n, (mode, run, position) in enumerate(rows)]


def _same(a: Outputs, b: Outputs) -> bool:
    def flat(out: Outputs) -> list[Any]:
        return [*[v for joint in out.joints for v in astuple(joint)], out.segment, out.finished, out.stopped, out.tip_correction_rad]

    return all(x == y or (isnan(x) and isnan(y)) for x, y in zip(flat(a), flat(b), strict=True))


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(stretches, st.sampled_from(["none", "adaptive", "robust_notch"]), st.floats(0, 1))
def test_any_inputs(plan: list[tuple[Mode, int, int, float, float]], kind: str, place: float) -> None:
    """Deterministic, restorable anywhere, never outside the limits, no command when off, and alive again after bad samples."""
    rig, inputs = _rig(), _inputs(plan)
    one, two = Controller(rig), Controller(rig)
    one.prepare(_plan(kind))
    two.prepare(_plan(kind))
    previous = [0.0, 0.0]
    for n, row in enumerate(inputs):
        if n == int(place * len(inputs)):
            two = Controller(rig)
            two.restore(json.loads(json.dumps(one.snapshot(), allow_nan=False)))
        out = one.step(row)
        assert _same(out, two.step(row))
        for j, (joint, limits) in enumerate(zip(out.joints, rig.joints.values(), strict=True)):
            assert isfinite(joint.command_V)
            assert abs(joint.command_V) <= limits.command_limit_V
            if row.mode in OFF:
                assert joint.command_V == 0.0
            else:
                assert abs(joint.command_V - previous[j]) <= limits.command_rate_limit_V_per_s * 1e-3 * (1 + 1e-9)
            previous[j] = joint.command_V
    _recovers(one)


def _recovers(controller: Controller) -> None:
    for n in range(3):
        controller.step(Inputs(n, Mode.DISARMED, 0, (0.1, 1.0), nan, nan))
    for n in range(3):
        out = controller.step(Inputs(n, Mode.HOLDING, 0, (0.1, 1.0), nan, nan))
    assert [j.reference for j in out.joints] == [0.1, 1.0]
    assert [abs(j.command_V) for j in out.joints] == [servo.dither_V for servo in _rig().servo.values()]


@pytest.mark.parametrize("kind", ["none", "zvd", "robust_notch", "adaptive", "adaptive_coefficients", "adaptive_delay"])
@pytest.mark.parametrize(("cycles", "then"), [(700, Mode.RUNNING), (9000, Mode.RUNNING), (9000, Mode.STOPPING)])
def test_restore_in_mid_run(kind: str, cycles: int, then: Mode) -> None:
    arm = IdealArm(_rig(), HOME)
    arm.start(_plan(kind), cycles)
    if then == Mode.STOPPING:
        arm.step(then, 1)
    copy = Controller(_rig())
    copy.restore(json.loads(json.dumps(arm.controller.snapshot(), allow_nan=False)))
    for n in range(1500):
        positions = tuple(arm.position)
        assert _same(arm.step(then, 1), copy.step(Inputs(n, then, 1, positions, nan, nan)))
