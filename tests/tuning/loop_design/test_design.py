"""The lag-lead search: at least as good as the published designs on their own terms, and a design for the whole arm that holds in time."""

from __future__ import annotations

import json
from functools import partial
from math import degrees
from pathlib import Path

import control
import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.rig import Rig
from daemon.cli.main import main
from tuning.arrays import Complexes, Floats
from tuning.experiments.release import ReleaseConditions, release, servo_of
from tuning.linear.closed_loop import Servo
from tuning.linear.family import HALF_HOLD_AND_SAMPLE_S, INERTIAS, eq1, members, valve
from tuning.linear.linear_arm import linear_arm
from tuning.loop_design.amplitude_members import amplitude_members
from tuning.loop_design.arm_design import OperatingPoint, arm_problem, as_overrides, worst_damping
from tuning.loop_design.lag_lead_design import Demands, DesignProblem, evaluate, search
from tuning.variants import without_effect

LAG = (8.0, 8.0 / 6)
INCH, POUND = 0.0254, 0.45359237
SPOOL = valve(60.0, 0.8)


def _with_delay(plant: control.TransferFunction, delay_s: float, omega: Floats) -> Complexes:
    return plant(1j * omega) * np.exp(-1j * omega * delay_s)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("published", "plants", "best_gain"),
    [
        (Servo(1.4586 * 6, ((59.58, 595.8), LAG)), [(eq1(m), 0.0) for m in members()], 0.71),
        (Servo(0.7158 * 6, ((55.24, 552.4), LAG)), [(eq1(m) * SPOOL, HALF_HOLD_AND_SAMPLE_S) for m in members()], 0.50),
        (
            Servo(0.4058 * 6, ((44.04, 440.4), LAG)),
            [(eq1(m) * SPOOL, HALF_HOLD_AND_SAMPLE_S) for m in members(inertias=INERTIAS)],
            0.35,
        ),
    ],
    ids="ABC",
)
def test_search_is_at_least_as_good_as_the_published_designs(
    published: Servo, plants: list[tuple[control.TransferFunction, float]], best_gain: float
) -> None:
    """Same family, same bounds, same M_s as theirs; stiffness judged by the common formula."""
    responses = tuple(partial(_with_delay, *plant) for plant in plants)
    theirs = evaluate(DesignProblem(responses), published)
    problem = DesignProblem(responses, Demands(sensitivity_peak=theirs.worst.sensitivity_peak))
    ours = search(problem)
    assert ours.stiffness_gain_dB >= theirs.stiffness_gain_dB - 0.005
    assert ours.worst.sensitivity_peak <= theirs.worst.sensitivity_peak + 0.001
    assert ours.worst.phase_margin_deg >= 45.0
    assert ours.worst.gain_margin_dB >= 6.0
    assert search(DesignProblem(responses), with_sections=False).servo.gain == pytest.approx(best_gain, abs=0.008)


def test_shipped_servo_keeps_its_promises(rig: Rig) -> None:
    """0.35 V/deg: margins, and a link that is damped at all gains of the family, with the end-point feedback and without."""
    problem = arm_problem(rig, 0.0)
    for servo, least in ((servo_of(rig), 0.015), (Servo(rig.servo["rotary"].gain), 0.0)):
        shipped = evaluate(problem, servo)
        assert shipped.worst.sensitivity_peak <= 1.7
        assert shipped.least_damping is not None
        assert shipped.least_damping > least


def test_a_feedback_that_needs_to_know_the_payload_is_seen(rig: Rig) -> None:
    """0.5 V/deg with the whole tip at 15 Hz is well damped with 45 and 75 lb, and unstable on an empty arm that believes in 45 lb."""
    places = [
        OperatingPoint(linear_arm(rig, inches * INCH, pounds * POUND), 1.0, False) for inches, pounds in ((54, 45), (54, 75), (54, 0))
    ]
    bold = Servo(degrees(0.5), (), 1.0, 15.0)
    assert worst_damping(places[:2], 0.001, 0.002, bold) > 0.05
    assert worst_damping(places[2:], 0.001, 0.002, bold) < -0.03
    assert worst_damping(places[2:], 0.001, 0.002, servo_of(rig)) > 0.0


@pytest.mark.slow
def test_margins_over_amplitude_are_the_published_ones(rig: Rig) -> None:
    """Worst of 0.1, 0.3, 1 and 3 V with 1.5 ms: phase margin °, gain margin dB, M_s; the published plant has no valve hysteresis."""
    problem = DesignProblem(amplitude_members(without_effect(rig, "valve_hysteresis"), HALF_HOLD_AND_SAMPLE_S, 36 * INCH))
    c = ((44.04, 440.4), LAG)
    for servo, phase, gain, peak in (
        (Servo(degrees(0.35)), 72.9, 14.9, 1.29),
        (Servo(degrees(0.5)), 65, 11.8, 1.45),
        (Servo(degrees(2.43), c), 61.8, 12.2, 1.39),
    ):
        worst = evaluate(problem, servo).worst
        assert worst.phase_margin_deg == pytest.approx(phase, abs=2.0)
        assert worst.gain_margin_dB == pytest.approx(gain, abs=0.8)
        assert worst.sensitivity_peak == pytest.approx(peak, abs=0.04)


@pytest.mark.slow
def test_design_command_writes_a_rig_that_is_quiet(rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With end-point feedback: stiffer than pure gain, written into the file, and no cycle where the link is worst."""
    out = tmp_path / "rig.yaml"
    assert main(["design", "ornl_testbed", "--tip-gain", "0.5", "--effort", "15", "--json", "-o", str(out)]) == 0
    found = json.loads(capsys.readouterr().out)
    chosen = found["chosen"]
    assert not found["pure_gain_wins"]
    assert chosen["worst"]["sensitivity_peak"] <= 1.705
    assert chosen["least_damping"] >= 0.0149
    written = load_rig(out).rig.servo["rotary"]
    assert written.gain == pytest.approx(chosen["servo"]["gain"], rel=1e-5)
    sections = tuple((s.zero_rad_per_s, s.pole_rad_per_s) for s in written.sections)
    servo = Servo(written.gain, sections, 0.5, chosen["servo"]["roll_off_Hz"])
    for inches, pounds in ((20, 45), (30, 45), (60, 75), (36, 0)):
        after = release(rig, ReleaseConditions(inches * 0.0254, pounds * 0.45359237), servo, 20.0)
        assert not after.oscillates
        assert after.tip_amplitude_m < 0.5e-3


def test_overrides_fit_the_rig_file() -> None:
    text = apply_overrides(
        load_rig("ornl_testbed").text, as_overrides(load_rig("ornl_testbed").rig, Servo(2.0 * degrees(1.0), ((50.0, 500.0), (8.0, 2.0))))
    )
    servo = rig_from_text(text).servo["rotary"]
    assert servo.gain == pytest.approx(2.0 * degrees(1.0))
    assert [(s.zero_rad_per_s, s.pole_rad_per_s) for s in servo.sections] == [(50.0, 500.0), (8.0, 2.0)]
