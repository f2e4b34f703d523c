"""Rows 17 to 23: the straight line, its kinematics, command filters with ideal joints and on the whole rig (Figures 9 and 10)."""

from __future__ import annotations

from math import degrees, pi

import numpy as np

from config.checking.check import feasible_y0
from config.loading.load import find, load_maneuver
from config.schema.maneuver import StraightLine
from config.schema.rig import Rig
from servo_control.link.kinematics import forward
from servo_control.planning.planning import plan_run
from servo_control.planning.prediction import predict
from servo_control.planning.run_request import RunRequest
from servo_control.shapers import impulses
from tuning.experiments.line_run import LineRun, coupled_run, ideal_run, plan_line, rms_dB, spectrum_dB
from tuning.paper.row import ClaimRow, figures, near
from tuning.variants import as_in_1997, without_effect

INCH_M = 0.0254
LINE_Y30, LINE_Y40 = "paper_line_y30", "paper_line"
# y0 in in: largest rotary excursion °, rate rad/s, acceleration rad/s², extension rate in/s
KINEMATICS = {20: (56.3, 0.500, 5.00, 8.28), 30: (45.0, 0.333, 3.33, 7.01), 40: (36.9, 0.250, 2.50, 5.93), 50: (31.0, 0.200, 2.00, 5.08)}


def straight_line(rig: Rig) -> ClaimRow:
    plan = plan_line(rig, LINE_Y30)
    rows = [(*forward(*cycle.target), *cycle.target_rate, *cycle.target) for cycle in predict(rig, plan)]
    x, y = np.array(rows).T[:2]
    speed = np.diff(x) * rig.loop.rate_Hz
    ends = [segment.end_s for segment in plan.segments if segment.kind == "move"]
    off_line_m = float(np.abs(y - y[0]).max())
    fastest, hardest = float(np.abs(speed).max()) / INCH_M, float(np.abs(np.diff(speed)).max()) * rig.loop.rate_Hz / INCH_M
    ok = near(ends, (3.1, 11.2, 16.3), absolute=1e-9) and fastest <= 10.0 * 1.0001 and hardest <= 100.0 * 1.001 and off_line_m <= 1e-4
    return ClaimRow(
        17,
        "minimum-time straight line",
        f"moves end at {figures(ends, '.1f')} s; {fastest:.2f} in/s, {hardest:.1f} in/s², off the line {1e3 * off_line_m:.1e} mm",
        "3.1 / 11.2 / 16.3 s; ≤ 10 in/s, ≤ 100 in/s², 0.1 mm",
        "exact",
        ok,
    )


def kinematics(rig: Rig) -> ClaimRow:
    """Peaks of the planned line at four distances, and the distances at which it fits."""
    base = load_maneuver(find("maneuvers", LINE_Y30)).maneuver
    assert isinstance(base, StraightLine)
    found: list[float] = []
    wanted: list[float] = []
    for inches, expected in KINEMATICS.items():
        content = {**base.model_dump(mode="json", by_alias=True), "y0": inches * INCH_M}
        rotary, prismatic = plan_run(rig, RunRequest(1, content)).peaks
        found += [degrees(rotary.highest), rotary.rate, rotary.acceleration, prismatic.rate / INCH_M]
        wanted += expected
    limits = feasible_y0(rig, 30 * INCH_M)
    nearest, farthest = (value / INCH_M for value in limits) if limits else (0.0, 0.0)
    return ClaimRow(
        18,
        "straight line in joint space",
        f"fits for y0 = {nearest:.2f}…{farthest:.2f} in; y0 = 30 in: ±{found[4]:.1f}°, {found[5]:.3f} rad/s, {found[7]:.2f} in/s",
        "12…51.96 in; ±45.0°, 0.333 rad/s, 7.01 in/s, and three other y0",
        "0.5 %",
        near([nearest, farthest], [12.0, 51.96], relative=5e-3) and near(found, wanted, relative=5e-3),
    )


def equation_14(_: Rig) -> ClaimRow:
    """The zero lies on the pole, for any T; published vectors for 4 Hz, ζ = 0.02."""
    damping = 0.02
    natural = 2.0 * pi * 4.0
    omega = natural * (1.0 - damping**2) ** 0.5
    pole = complex(-damping * natural, omega)
    zeros, gains = [], []
    for delay in (0.05, 0.07, 0.1, pi / omega):
        shaper = impulses.three_term(omega, damping, delay)
        zeros.append(abs(impulses.transfer(shaper, pole)))
        gains.append(abs(impulses.transfer(shaper, 0.0) - 1.0))
    amplitudes = impulses.three_term_amplitudes(omega, damping, 0.07)
    ok = max(zeros) <= 1e-12 and max(gains) <= 1e-12 and near(amplitudes, (0.43607463, 0.15748318, 0.40644219), absolute=1e-8)
    return ClaimRow(
        19,
        "Eq 14, both exponents −2ζω_nT",
        f"|F(p)| {max(zeros):.1e}, |F(0) − 1| {max(gains):.1e}, T = 0.07 s: {figures(amplitudes, '.8f')}",
        "0, 0, 0.43607463 / 0.15748318 / 0.40644219",
        "1e-12, 1e-8",
        ok,
    )


def unfiltered(rig: Rig) -> ClaimRow:
    amplitudes = ideal_run(rig, plan_line(rig, LINE_Y30)).hold_amplitudes.tolist()
    return ClaimRow(
        20,
        "Fig 9: considerable vibration without filter",
        f"y0 = 30 in, ideal joints: {figures(amplitudes, '.2f')} m/s² in the holds",
        "4.09 / 3.00 / 9.35 m/s²",
        "5 %",
        near(amplitudes, (4.09, 3.00, 9.35), relative=0.05),
    )


def three_term(rig: Rig) -> ClaimRow:
    base = ideal_run(rig, plan_line(rig, LINE_Y40))
    found = [spectrum_dB(_ideal(rig, LINE_Y40, kind="three_term", focal=focal), base) for focal in ("initial", "final")]
    return ClaimRow(
        21,
        "Fig 10: three-term filter, about 20 dB",
        f"y0 = 40 in, largest spectral line: {found[0]:.1f} dB (initial), {found[1]:.1f} dB (final)",
        "−17.8 / −19.5 dB",
        "2 dB",
        near(found, (-17.8, -19.5), absolute=2.0),
        "the paper does not give y0; at 30 in the same filter gives −10…−13 dB",
    )


def adaptive(rig: Rig) -> ClaimRow:
    base = ideal_run(rig, plan_line(rig, LINE_Y30))
    shaped = _ideal(rig, LINE_Y30, kind="adaptive")
    holds = (20.0 * np.log10(shaped.hold_amplitudes / base.hold_amplitudes)).tolist()
    wrong = [rms_dB(_ideal(rig, LINE_Y30, kind="adaptive", frequency_scale=scale), base) for scale in (0.9, 1.1)]
    return ClaimRow(
        22,
        "adaptive filter (work under way in 1997)",
        f"holds {figures(holds, '.1f')} dB; ±10 % frequency error {figures(wrong, '.1f')} dB rms",
        "≤ −40 dB in every hold; ≤ −28 dB rms",
        "–",
        max(holds) <= -40.0 and max(wrong) <= -28.0,
    )


def _ideal(rig: Rig, maneuver: str, **shaper: object) -> LineRun:
    return ideal_run(rig, plan_line(rig, maneuver, shaper))


def coupled(rig: Rig) -> ClaimRow:
    """Judged without valve hysteresis, with which the reference figures cannot have been made (see the note)."""
    plain = as_in_1997(rig)
    smooth = _reductions(without_effect(plain, "valve_hysteresis"))
    rough = _reductions(plain)
    return ClaimRow(
        23,
        "filters on the whole rig (friction, hydraulics)",
        f"y0 = 40 in: adaptive {smooth[0]:.1f} dB rms, ZVD {smooth[1]:.1f} dB rms",
        "≤ −25 dB, ≤ −15 dB",
        "–",
        smooth[0] <= -25.0 and smooth[1] <= -15.0,
        f"valve hysteresis off; with the rig file's 0.1 %: {rough[0]:.1f} and {rough[1]:.1f} dB. Unshaped holds without it"
        f" {figures(smooth[2], '.2f')} m/s², with it {figures(rough[2], '.2f')}; published 2.8 / 2.8 / 3.1 and −31.2 dB",
    )


def _reductions(rig: Rig) -> tuple[float, float, list[float]]:
    base = coupled_run(rig, plan_line(rig, LINE_Y40))
    shaped = [coupled_run(rig, plan_line(rig, LINE_Y40, shaper)) for shaper in ({"kind": "adaptive"}, {"kind": "zvd", "focal": "mid"})]
    return rms_dB(shaped[0], base), rms_dB(shaped[1], base), base.hold_amplitudes.tolist()
