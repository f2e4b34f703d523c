"""What five hours of warming up do to the joints, and how far the compensation of the feed-forward corrects it.

At every moment asked for the plant is identified at the temperature its oil has reached: sine tests and Eq 4's form fitted to them, and the
rate that the feed-forward alone gives against the rate asked for. Then the whole rig (controller, sensors, hydraulics, link) starts from
the heat stores' state, holds until the temperature sensors have settled, and makes a move: with the rig file's tables, and without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, sqrt

import numpy as np

from config.progress import Progress
from config.schema.rig import Rig
from servo_control.planning.run_plan import RunPlan
from servo_control.servo.oil_compensation import OilCompensation
from tuning.arrays import Complexes, Floats
from tuning.experiments.excited_run import ResponseConditions
from tuning.experiments.five_hours import HOURS, START_C, FiveHours, five_hours
from tuning.experiments.line_run import coupled_run, plan_line
from tuning.experiments.sine_test import EXTENSION_M, rotary, velocity_response
from tuning.oil.oil_table import steady_rate
from tuning.paper.row import SWEEP_HZ
from tuning.responses.frequency_response import FrequencyResponse
from tuning.responses.response_fit import fit_joint
from tuning.variants import with_servo

SETTLING_S = 15.0  # holding before the move: three lags of the temperature sensors
REFERENCE_C = 40.0  # to which gains are compared; docs/method/plant.md states them at it
SMALL_V, FIT_V = 0.1, 0.3  # of Figure 3's row and of Eq 4's
SLOW_SHARE = 0.25  # of the joint's rate limit, at which the feed-forward alone is tested


@dataclass(frozen=True, slots=True)
class Lag:
    """One move: error reference − position over the moves, rms and largest, per joint (rad, m)."""

    rms: tuple[float, ...]
    largest: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class EqFour:
    """Of the rotary joint at 0.3 V: velocity gain K/b in degrees per V·s, √b in Hz, damping ratio a/(2√b)."""

    velocity_gain: float
    frequency_Hz: float
    damping_ratio: float


@dataclass(frozen=True, slots=True, eq=False)
class WarmUpMoment:
    """`small_gain`: at 0.1 V and 0.5 Hz, over that at 40 °C. `rate_share`: rate over the rate asked for by the feed-forward alone, forth
    and back, by joint. `response`: rad/s per V at SWEEP_HZ and 0.1 V."""

    t_s: float
    reservoir_C: float
    oil_C: float
    small_gain: float
    eq4: EqFour
    response: Complexes
    rate_share: dict[str, dict[str, tuple[float, float]]]
    lag: dict[str, Lag]


@dataclass(frozen=True, slots=True, eq=False)
class WarmUpStudy:
    ran: FiveHours
    maneuver: str
    moments: tuple[WarmUpMoment, ...]


def warm_up_study(
    rig: Rig,
    moments_s: Sequence[float],
    maneuver: str = "paper_line",
    hours: float = HOURS,
    start_C: float = START_C,
    progress: Progress = lambda line: None,
) -> WarmUpStudy:
    """Raises PlantError when the rig's plant has no thermal section or other joints than a rotary and a prismatic one."""
    moments = sorted(moments_s)
    ran = five_hours(rig, moments, hours, start_C, progress)
    plan = plan_line(rig, maneuver, {"kind": "adaptive", "joints": ["rotary", "prismatic"]})
    return WarmUpStudy(ran, maneuver, tuple(_moment(rig, plan, t, heat, progress) for t, heat in zip(moments, ran.heat, strict=True)))


def without_tables(rig: Rig) -> Rig:
    """One feed-forward for all temperatures. (The end-point feedback's push against friction needs the rotary table and goes with it.)"""
    for joint in rig.joints:
        rig = with_servo(rig, joint, oil_compensation=None)
    return rig


def lag(rig: Rig, plan: RunPlan, heat: Floats) -> Lag:
    """The move from a state of the heat stores (RESERVOIR to OIL, degC)."""
    run = coupled_run(rig, plan, heat_C=heat, holding_s=SETTLING_S)
    moving = np.zeros(len(run.reference), dtype=bool)
    for segment in run.plan.segments:
        if segment.kind == "move":
            moving[round(segment.start_s / run.period_s) : round(segment.end_s / run.period_s)] = True
    error = (run.reference - run.position)[moving]
    rms, largest = np.sqrt(np.mean(error**2, axis=0)), np.max(np.abs(error), axis=0)
    return Lag(tuple(map(float, rms)), tuple(map(float, largest)))


def _moment(rig: Rig, plan: RunPlan, t_s: float, heat: Floats, progress: Progress) -> WarmUpMoment:
    oil_C = float(heat[-1])
    progress(f"identifying and moving at {t_s / 3600.0:.2f} h, oil {oil_C:.1f} °C")
    variants = {"without": without_tables(rig), "with": rig}
    response = velocity_response(rig, rotary(oil_C), SMALL_V, SWEEP_HZ)
    small = [abs(complex(velocity_response(rig, rotary(T), SMALL_V, [0.5])[0])) for T in (oil_C, REFERENCE_C)]
    return WarmUpMoment(
        t_s, float(heat[0]), oil_C, small[0] / small[1], _eq4(rig, oil_C), response,
        {name: {joint: rate_shares(each, joint, oil_C) for joint in rig.joints} for name, each in variants.items()},
        {name: lag(each, plan, heat) for name, each in variants.items()},
    )  # fmt: skip


def _eq4(rig: Rig, oil_C: float) -> EqFour:
    frequencies = np.array(SWEEP_HZ)
    response = velocity_response(rig, rotary(oil_C), FIT_V, SWEEP_HZ) / (2j * np.pi * frequencies)
    sure = np.full(len(frequencies), 1e-3)
    where = ResponseConditions("rotary", "command", FIT_V, EXTENSION_M, oil_C, 0.0)
    fit = fit_joint(FrequencyResponse("sine tests", where, frequencies, response, sure, np.ones(len(sure)), np.full(len(sure), FIT_V)))
    root = sqrt(fit.values["stiffness"])
    return EqFour(degrees(fit.velocity_gain), root / (2.0 * np.pi), fit.values["damping"] / (2.0 * root))


def rate_shares(rig: Rig, joint: str, oil_C: float) -> tuple[float, float]:
    """Rate that the feed-forward alone gives over the rate asked for, forth and back; 1 is right."""
    servo, wanted = rig.servo[joint], SLOW_SHARE * rig.joints[joint].rate_limit
    table = None
    if servo.oil_compensation is not None:
        table = OilCompensation(servo.oil_compensation, servo.velocity_feedforward, 1.0 / rig.loop.rate_Hz)
        table.measure(oil_C)
    shares = []
    for rate in (wanted, -wanted):
        volts = servo.velocity_feedforward * rate + servo.null_bias_V
        volts += table.volts(rate) + table.bias_V if table is not None else 0.0
        shares.append(steady_rate(rig, joint, volts, oil_C) / rate)
    return shares[0], shares[1]
