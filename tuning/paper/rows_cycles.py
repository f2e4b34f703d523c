"""Rows 6 to 8 and 24 to 26: limit cycles, link damping, margins as they run, Book's rule."""

from __future__ import annotations

from functools import partial
from math import degrees

import control
import numpy as np

from config.schema.rig import Rig
from servo_control.link.link_mode import LinkFrequency
from tuning.arrays import Complexes, Floats
from tuning.experiments.release import Release, ReleaseConditions, release
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.limit_cycles.exact_cycle import ExactLoop, gain_for_frequency
from tuning.limit_cycles.limit_cycles import PredictedCycle, predict_limit_cycles
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import INERTIAS, Member, eq1, members, sampled_compensator, sampled_plant, valve
from tuning.linear.linear_arm import linear_arm
from tuning.linear.margins import margins
from tuning.paper.row import PAYLOAD_KG, ClaimRow, near
from tuning.transfer import EQ4

INCH_M, POUND_KG, PER_DEG = 0.0254, 0.45359237, degrees(1.0)
# gain factor, H_s/H_c: describing function (Hz, M/H_c), exact (Hz, M/H_c), for Eq 4 in a unity loop
CYCLES = {
    (0.8, 1.1): ((0.305, 1.0505), (0.451, 1.062)),
    (0.8, 1.2): ((0.587, 1.102), (0.836, 1.125)),
    (1.0, 1.1): ((0.383, 1.0508), (0.599, 1.067)),
    (1.0, 1.2): ((0.740, 1.1032), (1.100, 1.134)),
    (1.2, 1.1): ((0.463, 1.0512), (0.772, 1.073)),
    (1.2, 1.2): ((0.900, 1.1047), (1.400, 1.146)),
    (2.0, 1.1): ((0.806, 1.054), (2.15, 1.140)),
    (2.0, 1.2): ((1.643, 1.117), (3.53, 1.281)),
    (2.5, 1.0): ((8.72, 2.92), (8.91, 3.12)),
    (3.0, 1.2): ((11.08, 9.05), (11.09, 9.13)),
}
DAMPING_PLACES = ((60.0, 0.0), (12.0, 45.0), (20.0, 45.0), (30.0, 45.0), (36.0, 45.0), (48.0, 45.0), (60.0, 45.0), (60.0, 75.0))
PERIOD_S = 0.001
DESIGN_C = Servo(0.4058 * 6.0, ((44.04, 440.4), (8.0, 8.0 / 6.0)))


def predictions(k: float, ratio: float) -> list[PredictedCycle]:
    return predict_limit_cycles(k * EQ4, FrictionCompliance.of_ratio(ratio))


def intersections(_: Rig) -> ClaimRow:
    found: list[float] = []
    wanted: list[float] = []
    for (k, ratio), (expected, _exact) in CYCLES.items():
        stable = [p for p in predictions(k, ratio) if p.stable]
        best = min(stable, key=lambda p: abs(p.frequency_Hz - expected[0]))
        found += [best.frequency_Hz, best.amplitude]
        wanted += expected
    none = [len(predictions(k, 1.0)) for k in (0.8, 1.0, 1.2)]
    unity = [p for k in (0.8, 1.0, 1.2) for ratio in (1.1, 1.2) for p in predictions(k, ratio)]
    low, high = min(p.frequency_Hz for p in unity), max(p.frequency_Hz for p in unity)
    return ClaimRow(
        6,
        "Fig 6: intersections at 5–6 Hz",
        f"Eq 4 × {{0.8, 1, 1.2}}: {low:.2f}–{high:.2f} Hz, none for H_s = H_c",
        "0.31–0.90 Hz, none for H_s = H_c; ten published pairs",
        "1 %",
        near(found, wanted, relative=0.01) and none == [0, 0, 0],
        f"the filter hypothesis fails in {sum(p.doubtful for p in unity)} of {len(unity)} of them; see row 7 for what is really there",
    )


def exact_cycles(_: Rig) -> ClaimRow:
    found: list[float] = []
    wanted: list[float] = []
    for (k, ratio), (_df, expected) in CYCLES.items():
        cycle = ExactLoop(k * EQ4, FrictionCompliance.of_ratio(ratio)).march(1.0)
        found += [cycle.frequency_Hz, cycle.amplitude] if cycle else [0.0, 0.0]
        wanted += expected
    gain = gain_for_frequency(EQ4, FrictionCompliance.of_ratio(1.2), 5.5, 2.1)
    unity = [found[2 * i] for i, (k, _) in enumerate(CYCLES) if k <= 1.2]
    return ClaimRow(
        7,
        "Fig 6, solved exactly",
        f"Eq 4 × {{0.8, 1, 1.2}}: {min(unity):.2f}–{max(unity):.2f} Hz; 5.5 Hz with H_s/H_c = 1.2 needs a gain of {gain:.3f}",
        "0.45–1.40 Hz; 2.214; ten published pairs",
        "3 % in frequency and amplitude",
        near(found, wanted, relative=0.03) and near([gain], [2.214], relative=0.03),
    )


def release_cases(rig: Rig) -> dict[str, Release]:
    """30 in, 45 lb, let go 2° away: unity gain; the gain just low enough; with reflected tip; with the true tip."""
    place = ReleaseConditions(30 * INCH_M, PAYLOAD_KG)
    servos = {
        "k = 1": Servo(PER_DEG),
        "k = 0.7": Servo(0.7 * PER_DEG),
        "k = 1, g = 0.5": Servo(PER_DEG, (), 0.5),
        "k = 0.35, g = −0.5": Servo(0.35 * PER_DEG, (), -0.5),
    }
    return {name: release(rig, place, servo) for name, servo in servos.items()}


def five_hertz(rig: Rig) -> ClaimRow:
    found = release_cases(rig)
    cycle = found["k = 1"]
    ok = abs(cycle.frequency_Hz - 4.99) <= 0.2 and abs(cycle.angle_amplitude_deg - 0.91) <= 0.15 * 0.91
    ok = ok and not found["k = 0.7"].oscillates and not found["k = 1, g = 0.5"].oscillates and found["k = 0.35, g = −0.5"].oscillates
    states = ", ".join(f"{name}: {'oscillates' if run.oscillates else 'at rest'}" for name, run in found.items() if name != "k = 1")
    return ClaimRow(
        8,
        "a limit cycle of about 5 Hz was observed",
        f"30 in, 45 lb, k = 1, 2° release: {cycle.frequency_Hz:.2f} Hz, {cycle.angle_amplitude_deg:.2f}°; {states}",
        "4.99 Hz, 0.91°; at rest for k ≤ 0.7 and with g = 0.5; g = −0.5 oscillates",
        "0.2 Hz, 15 %",
        ok,
        f"tip ±{1e3 * cycle.tip_amplitude_m:.0f} mm: the link's mode, undamped by the joint; not friction with drive-train compliance",
    )


def reflected_tip(rig: Rig) -> ClaimRow:
    period_s = 1.0 / rig.loop.rate_Hz
    arms = [linear_arm(rig, inches * INCH_M, pounds * POUND_KG) for inches, pounds in DAMPING_PLACES]
    good = [least_damping(sampled_loop(arm, Servo(0.5 * PER_DEG, (), 0.5), period_s), period_s) for arm in arms]
    bad = [least_damping(sampled_loop(arm, Servo(0.35 * PER_DEG, (), -0.5), period_s), period_s) for arm in arms[3:]]
    return ClaimRow(
        24,
        "passive tip feedback (Wang, Vidyasagar)",
        f"P 0.5, g = 0.5: least damping {min(good):.3f}; g = −0.5: {max(bad):.3f} at best where loaded",
        "≥ 0.015; unstable",
        "–",
        min(good) >= 0.015 and max(bad) < 0.0,
        "sampled at the loop's rate, eight places from 12 to 60 in and 0 to 75 lb",
    )


def lag_lead_margins(_: Rig) -> ClaimRow:
    spool = valve(60.0, 0.8)
    found = [margins(partial(_sampled, member, spool)) for member in members(inertias=INERTIAS)]
    gain, phase, peak = (
        min(m.gain_margin_dB for m in found),
        min(m.phase_margin_deg for m in found),
        max(m.sensitivity_peak for m in found),
    )
    return ClaimRow(
        25,
        "lag-lead filters with margin and stiffness",
        f"design C at 1 kHz, worst member: {gain:.2f} dB, {phase:.1f}°, M_s {peak:.3f}",
        "≥ 10 dB, ≥ 55°, ≤ 1.71",
        "0.1 dB, 0.5°",
        gain >= 9.9 and phase >= 54.5 and peak <= 1.71,
    )


def _sampled(member: Member, spool: control.TransferFunction, omega: Floats) -> Complexes:
    z = np.exp(1j * omega * PERIOD_S)
    return np.asarray(sampled_compensator(DESIGN_C, PERIOD_S)(z) * sampled_plant(eq1(member) * spool, PERIOD_S)(z))


def books_rule(rig: Rig) -> ClaimRow:
    assert rig.link_mode is not None
    link = LinkFrequency(rig.link_mode.model_copy(update={"payload_kg": PAYLOAD_KG}))
    third = [link.frequency_Hz(inches * INCH_M) / 3.0 for inches in (60.0, 12.0)]
    return ClaimRow(
        26,
        "Book: joint bandwidth up to 1/3 of the clamped frequency",
        f"{third[0]:.2f} Hz (60 in, 45 lb) … {third[1]:.2f} Hz (12 in)",
        "0.63 … 7.2 Hz",
        "1 %",
        near(third, (1.892 / 3.0, 21.528 / 3.0), relative=0.01),
    )
