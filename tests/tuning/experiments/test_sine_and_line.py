"""Amplitude tables, temperature table and lines against the published figures (independent simulation with its own plant code)."""

from __future__ import annotations

from math import degrees, sqrt

import numpy as np
import pytest

from config.loading.load import find, load_maneuver, load_rig, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.maneuver import maneuver_content
from config.schema.oil_compensation import RotaryOilCompensation
from config.schema.rig import Rig
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from tuning.experiments.judged_holds import judged_holds
from tuning.experiments.line_run import coupled_run, ideal_run, plan_line, rms_dB, spectrum_dB
from tuning.experiments.sine_test import SineTest, decibels, relative_to_eq4, rotary, velocity_response
from tuning.shaper_choice.shape_prediction import lateness
from tuning.variants import PRISMATIC, as_in_1997, with_link, with_servo, with_valve, without_effect

ADAPTIVE: dict[str, object] = {"kind": "adaptive", "joints": ["rotary", "prismatic"]}
WITHOUT_DELAY: dict[str, object] = {"kind": "zero_delay"}
HALF_A_CYCLE: dict[str, object] = {"kind": "adaptive_zv", "joints": ["rotary", "prismatic"]}
HZ = (0.5, 2.0, 5.0, 8.0, 12.0)
# dB and degrees relative to Eq 4 at HZ, without valve hysteresis
ROTARY = {
    0.1: ((-2.3, -2.8, -4.8, -6.4, -4.7), (2, 0, 1, 18, 31)),
    0.3: ((-0.4, -0.4, -0.1, 0.3, 0.8), (1, 1, 0, -1, -2)),
    1.0: ((-0.7, -0.5, 0.2, 1.5, 3.1), (1, 2, 4, 2, -10)),
}


@pytest.mark.parametrize("volts", ROTARY)
def test_rotary_amplitude_table(rig: Rig, volts: float) -> None:
    """Without hysteresis the published table comes out to 0.3 dB and 1.5°: it was made without."""
    gain, phase = relative_to_eq4(HZ, velocity_response(without_effect(rig, "valve_hysteresis"), rotary(), volts, HZ))
    assert gain == pytest.approx(np.array(ROTARY[volts][0]), abs=0.3)
    assert phase == pytest.approx(np.array(ROTARY[volts][1]), abs=1.5)


def test_prismatic_amplitude_table(rig: Rig) -> None:
    """Published spread 2.7/5, 3.9/13, 4.7/17, 5.5/22, 7.2/22 (dB/°) at 1, 3, 5, 8, 12 Hz: null in the middle, no hysteresis."""
    variant = with_valve(without_effect(rig, "valve_hysteresis"), PRISMATIC, null_adjustment=0.0)
    test = SineTest(PRISMATIC, 45 * 0.45359237)
    found = np.array([velocity_response(variant, test, volts, (1.0, 3.0, 5.0, 8.0, 12.0)) for volts in (0.1, 0.2, 0.5, 1.0)])
    assert np.ptp(decibels(found)[0], axis=0) == pytest.approx(np.array([2.7, 3.9, 4.7, 5.5, 7.2]), abs=0.3)
    assert np.ptp(decibels(found)[1], axis=0) == pytest.approx(np.array([5, 13, 17, 22, 22]), abs=2)


@pytest.mark.parametrize(("volts", "changes"), [(0.1, (19, 11, -13, -28)), (0.3, (4.9, 3.3, -4.6, -10)), (1.0, (-4.4, -0.8, -1.0, -3.3))])
def test_gain_over_temperature(rig: Rig, volts: float, changes: tuple[float, ...]) -> None:
    """0.5 Hz gain at 20, 30, 50 and 60 °C relative to 40 °C, percent."""
    gain = [abs(velocity_response(rig, rotary(t), volts, [0.5])[0]) for t in (20.0, 30.0, 50.0, 60.0, 40.0)]
    assert 100 * (np.array(gain[:4]) / gain[4] - 1) == pytest.approx(np.array(changes), abs=1.5)


def test_ideal_joints(rig: Rig) -> None:
    """Rows 20 and 21 with the plant's own link."""
    assert ideal_run(rig, plan_line(rig, "paper_line_y30")).hold_amplitudes == pytest.approx(np.array([4.09, 3.00, 9.35]), rel=0.05)
    base = ideal_run(rig, plan_line(rig, "paper_line"))
    fixed = ideal_run(rig, plan_line(rig, "paper_line", {"kind": "three_term", "focal": "initial"}))
    assert spectrum_dB(fixed, base) == pytest.approx(-17.8, abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "unshaped", "reductions"),
    [("paper_line", (2.8, 2.8, 3.1), (-17.8, -23.6, -31.2)), ("paper_line_y30", (2.8, 2.7, 3.6), (-12.9, -30.7, -17.6))],
)
def test_coupled_runs_without_hysteresis_are_the_published_ones(
    rig: Rig, line: str, unshaped: tuple[float, ...], reductions: tuple[float, ...]
) -> None:
    """Unshaped within 5 %; ZVD, two-hump EI (mid) and adaptive within 1 dB. With the shipped hysteresis they are not."""
    variant = without_effect(as_in_1997(rig), "valve_hysteresis")
    base = coupled_run(variant, plan_line(variant, line))
    assert base.hold_amplitudes == pytest.approx(np.array(unshaped), rel=0.05)
    shapers = ({"kind": "zvd", "focal": "mid"}, {"kind": "two_hump_ei", "focal": "mid"}, {"kind": "adaptive"})
    found = [rms_dB(coupled_run(variant, plan_line(variant, line, shaper)), base) for shaper in shapers]
    assert found == pytest.approx(reductions, abs=1.0)


@pytest.mark.slow
def test_holds_without_end_point_feedback(rig: Rig) -> None:
    """Adaptive filter and the best servo of the joint alone (friction fed forward as well), y0 = 40 in: 31 dB below the line of 1997."""
    friction = {"source": "rotary.return_temperature", "points": ({"temperature": 40.0, "friction": 0.02},)}
    changes = {"gain": degrees(0.3), "oil_compensation": RotaryOilCompensation.model_validate(friction)}
    joint_only = with_servo(rig, "rotary", **changes).model_copy(update={"end_point": None})
    shaped = coupled_run(joint_only, plan_line(joint_only, "paper_line", ADAPTIVE))
    plain = as_in_1997(rig)
    assert rms_dB(shaped, coupled_run(plain, plan_line(plain, "paper_line"))) < -31.0


LINES = ("paper_line", "paper_line_y30")
ERRORS = (0.9, 1.0, 1.1)  # of the filter's frequency


def _largest(rig: Rig, line: str, shaper: dict[str, object], payload: float, scale: float = 1.0, oil_C: float = 40.0) -> float:
    """Largest hold (m/s²). `payload`: the true one over the believed one; `scale`: the filter's frequency over the believed one."""
    true = with_link(rig, payload_kg=payload * 45 * 0.45359237)
    return float(coupled_run(true, plan_line(rig, line, {**shaper, "frequency_scale": scale}), temperature_C=oil_C).hold_amplitudes.max())


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
def test_holds_as_shipped(rig: Rig, line: str) -> None:
    """Adaptive filter on both joints: 0.05 m/s² in every hold, 0.1 with a frequency 10 % or a payload 20 % wrong, 36 dB below 1997."""
    assert _largest(rig, line, ADAPTIVE, 1.0) <= 0.05
    assert max(_largest(rig, line, ADAPTIVE, 1.0, scale) for scale in (0.9, 1.1)) <= 0.1
    assert max(_largest(rig, line, ADAPTIVE, payload) for payload in (0.8, 1.2)) <= 0.1
    plain = as_in_1997(rig)
    shaped = coupled_run(rig, plan_line(rig, line, ADAPTIVE))
    assert rms_dB(shaped, coupled_run(plain, plan_line(plain, line))) < -36.0


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
def test_holds_without_delay(rig: Rig, line: str) -> None:
    """`zero_delay` ends every move on time and leaves 0.05 m/s², 0.1 with frequency and payload both wrong; 0.06 in cold and hot oil."""
    plan = plan_line(rig, line, WITHOUT_DELAY)
    assert plan.flush_s == 0.0
    assert plan.motion_end_s == plan_line(rig, line).motion_end_s
    assert _largest(rig, line, WITHOUT_DELAY, 1.0) <= 0.05
    assert max(_largest(rig, line, WITHOUT_DELAY, payload, scale) for payload in (0.8, 1.0, 1.2) for scale in ERRORS) <= 0.1
    assert max(_largest(rig, line, WITHOUT_DELAY, 1.0, oil_C=oil_C) for oil_C in (20.0, 60.0)) <= 0.06


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
def test_holds_with_half_a_cycle_of_filter_under_smooth_ramps(rig: Rig, line: str) -> None:
    """`adaptive_zv`: 0.02 m/s² in every hold, 0.05 with frequency and payload both wrong; the arm arrives no later than unfiltered."""
    shaped, plain = (coupled_run(rig, plan_line(rig, line, shaper)) for shaper in (HALF_A_CYCLE, {"kind": "none"}))
    assert shaped.hold_amplitudes.max() <= 0.02
    joints = list(rig.joints)
    for hold in judged_holds(plain.plan, plain.link)[0]:
        late, unfiltered = (lateness(run.position, hold.end_s, run.period_s, joints) for run in (shaped, plain))
        assert late <= unfiltered
    assert max(_largest(rig, line, HALF_A_CYCLE, payload, scale) for payload in (0.8, 1.0, 1.2) for scale in ERRORS) <= 0.05
    assert max(_largest(rig, line, HALF_A_CYCLE, 1.0, oil_C=oil_C) for oil_C in (20.0, 60.0)) <= 0.04


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("pounds", [5.0, 10.0, 20.0, 30.0, 60.0, 75.0])
def test_holds_with_half_a_cycle_of_filter_and_other_payloads(rig: Rig, line: str, pounds: float) -> None:
    """`adaptive_zv`, payload known: 0.05 m/s² in every hold; 0.1 with a frequency 10 % and a payload 20 % wrong together."""
    assert rig.link_mode is not None
    known = rig.model_copy(update={"link_mode": rig.link_mode.model_copy(update={"payload_kg": pounds * 0.45359237})})
    assert _largest(known, line, HALF_A_CYCLE, pounds / 45.0) <= 0.05
    wrong = ((0.8, 0.9), (0.8, 1.1), (1.2, 0.9), (1.2, 1.1))
    assert max(_largest(known, line, HALF_A_CYCLE, payload * pounds / 45.0, scale) for payload, scale in wrong) <= 0.1


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
def test_holds_with_a_deflection_sensor_that_is_off(line: str) -> None:
    """By 1 mm, which asks for more than the whole share of the friction: 0.05 m/s² all the same."""
    off = rig_from_text(apply_overrides(load_rig("ornl_testbed").text, ["plant.sensors.tip.deflection.bias=1 mm"]))
    assert coupled_run(off, plan_line(off, line, WITHOUT_DELAY)).hold_amplitudes.max() <= 0.05


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("pounds", [10.0, 20.0])
def test_holds_with_a_light_payload_that_is_known(rig: Rig, line: str, pounds: float) -> None:
    """8 and 11 Hz at 30 in, where the feedback leads: 0.05 m/s² in every hold, 0.1 with a payload 20 % wrong."""
    assert rig.link_mode is not None
    known = rig.model_copy(update={"link_mode": rig.link_mode.model_copy(update={"payload_kg": pounds * 0.45359237})})
    assert _largest(known, line, ADAPTIVE, pounds / 45.0) <= 0.05
    assert max(_largest(known, line, ADAPTIVE, wrong * pounds / 45.0) for wrong in (0.8, 1.2)) <= 0.1


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("pounds", [0.0, 5.0, 10.0, 20.0, 30.0, 60.0, 75.0])
def test_holds_without_delay_over_the_whole_payload_range(rig: Rig, line: str, pounds: float) -> None:
    """`zero_delay`, payload known: 0.05 m/s² in every hold; 0.1 with a filter frequency 10 % and a payload 20 % wrong together."""
    assert rig.link_mode is not None
    known = rig.model_copy(update={"link_mode": rig.link_mode.model_copy(update={"payload_kg": pounds * 0.45359237})})
    assert _largest(known, line, WITHOUT_DELAY, pounds / 45.0) <= 0.05
    wrong = ((0.8, 0.9), (0.8, 1.1), (1.2, 0.9), (1.2, 1.1)) if pounds > 0.0 else ((1.0, 0.9), (1.0, 1.1))
    assert max(_largest(known, line, WITHOUT_DELAY, payload * pounds / 45.0, scale) for payload, scale in wrong) <= 0.1


@pytest.mark.slow
@pytest.mark.parametrize("line", LINES)
@pytest.mark.parametrize("shaper", [WITHOUT_DELAY, HALF_A_CYCLE], ids=["zero_delay", "adaptive_zv"])
def test_holds_of_an_empty_arm_whatever_the_noise(rig: Rig, line: str, shaper: dict[str, object]) -> None:
    """No payload, 13 to 37 Hz: 0.05 m/s² in every hold, with five drawings of the sensors' noise. Without the notch it is 0.06 to 0.12."""
    empty = _empty(rig)
    plan = plan_line(empty, line, shaper)
    assert max(float(coupled_run(empty, plan, seed).hold_amplitudes.max()) for seed in range(5)) <= 0.05


@pytest.mark.parametrize("inches", [30.0, 42.4])
def test_the_encoder_does_not_shake_an_empty_arm_at_rest(rig: Rig, inches: float) -> None:
    """Held for five seconds: 0.04 m/s² at 36 and 18 Hz without the notch, all of it from the encoder; less than a quarter with it."""
    content = {**maneuver_content(load_maneuver(find("maneuvers", "hold")).maneuver), "duration": 5.0}
    request = RunRequest(1, content, {"kind": "none"}, start_position=[0.2, inches * 0.0254])
    fine = [
        "plant.sensors.rotary.position={resolution: 5e-5 deg, noise: 2e-5 deg, low: -90 deg, high: 90 deg}",
        "signals.rotary.position.calibration={scale: 5e-5 deg}",
    ]
    without = with_servo(_empty(rig), "rotary", link_notch=None)
    exact = with_servo(_empty(rig_from_text(apply_overrides(load_rig("ornl_testbed").text, fine))), "rotary", link_notch=None)
    shaken, sure, calm = (
        sqrt(2.0) * float(np.std(coupled_run(each, plan_run(each, request)).tip_acceleration[1000:]))
        for each in (without, exact, _empty(rig))
    )
    assert shaken > 0.025
    assert sure < 0.002
    assert calm < 0.25 * shaken


def _empty(rig: Rig) -> Rig:
    """Without payload, and knowing it."""
    assert rig.link_mode is not None
    return with_link(rig, payload_kg=0.0).model_copy(update={"link_mode": rig.link_mode.model_copy(update={"payload_kg": 0.0})})
