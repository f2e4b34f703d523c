"""A maneuver on the simulated rig in lockstep: the running controller, sensors and plant, and the vibration left in every hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import nan, sqrt
from typing import Any

import numpy as np

from config.loading.load import find, load_maneuver
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from recording.evaluation.spectrum import hann_spectrum
from recording.evaluation.vibration import AFTER_MOVE_S, decaying_sine
from servo_control.controller import Controller
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.planning import plan_run
from servo_control.planning.prediction import predict
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.servo.oil_compensation import temperature_signals
from servo_control.signals import Inputs, Mode
from sim_backend.kernel.prescribed import link_response
from sim_backend.memory.layout import H
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.experiments.judged_holds import JudgedHold, judged_holds
from tuning.variants import PRISMATIC, ROTARY

SETTLING_S = 1.0  # holding before the run starts, in which bias and end-point feedback fade in
SPECTRUM_HZ = (1.0, 25.0)


@dataclass(frozen=True)
class LineRun:
    """One run, samples from its first RUNNING cycle. True values; `reference` and `position` in the order of the joints (rad, m)."""

    plan: RunPlan
    period_s: float
    tip_acceleration: Floats
    tip_deflection: Floats
    reference: Floats
    position: Floats
    link: LinkFrequency

    @cached_property
    def hold_amplitudes(self) -> Floats:
        """Amplitude of the tip's vibration 1.0 s after the planned end of every move whose hold is long enough, m/s²."""
        return np.array([self.amplitude(hold) for hold in judged_holds(self.plan, self.link)[0]])

    @property
    def largest_line(self) -> float:
        """Largest line of the Hann spectrum of the whole record, 1 to 25 Hz, m/s²."""
        frequencies, lines = hann_spectrum(self.tip_acceleration, self.period_s)
        return float(lines[(frequencies >= SPECTRUM_HZ[0]) & (frequencies <= SPECTRUM_HZ[1])].max())

    def amplitude(self, hold: JudgedHold) -> float:
        """Of the tip's vibration 1.0 s after the move's end, m/s²."""
        first, last = (round((hold.end_s + since_s) / self.period_s) for since_s in hold.window_s)
        rows = np.arange(first, min(last, len(self.tip_acceleration)))
        t = np.asarray(rows * self.period_s - hold.end_s - AFTER_MOVE_S, dtype=np.float64)
        return decaying_sine(t, self.tip_acceleration[rows], hold.frequency_Hz, self.link.damping_ratio)[0]


def rms_dB(run: LineRun, base: LineRun) -> float:
    """Hold amplitudes of a run against those of another, root mean square over the holds."""
    return float(10.0 * np.log10(np.sum(run.hold_amplitudes**2) / np.sum(base.hold_amplitudes**2)))


def rms_mps2(run: LineRun) -> float:
    return sqrt(float(np.mean(run.hold_amplitudes**2)))


def spectrum_dB(run: LineRun, base: LineRun) -> float:
    return float(20.0 * np.log10(run.largest_line / base.largest_line))


def plan_line(rig: Rig, maneuver: str, shaper: Mapping[str, Any] | None = None) -> RunPlan:
    """Plan a shipped maneuver."""
    content = maneuver_content(load_maneuver(find("maneuvers", maneuver)).maneuver)
    return plan_run(rig, RunRequest(1, content, dict(shaper or {"kind": "none"})))


def ideal_run(rig: Rig, plan: RunPlan) -> LineRun:
    """The link on joints that follow their references exactly."""
    rows = np.array([(*cycle.reference, *cycle.reference_rate) for cycle in predict(rig, plan)])
    period_s = 1.0 / rig.loop.rate_Hz
    theta, length, theta_d, length_d = rows.T
    t = period_s * np.arange(len(rows))
    theta_dd, length_dd = np.gradient(theta_d, period_s), np.gradient(length_d, period_s)
    acceleration, deflection = link_response(rig, t, theta, theta_d, theta_dd, length, length_d, length_dd)
    keep = round(plan.program.duration_s / period_s)  # the same span for every shaper
    assert rig.link_mode is not None
    return LineRun(plan, period_s, acceleration[:keep], deflection[:keep], rows[:keep, :2], rows[:keep, :2], LinkFrequency(rig.link_mode))


def coupled_run(
    rig: Rig,
    plan: RunPlan,
    seed: int = 0,
    temperature_C: float | None = None,
    heat_C: Floats | None = None,
    holding_s: float = SETTLING_S,
    resting_s: float = 0.0,
) -> LineRun:
    """The whole rig: controller as in the daemon, sensors with noise and counts, hydraulics, friction, link.

    `heat_C`: temperatures of the heat stores (RESERVOIR to OIL) to start from; `holding_s`: holding before the run; `resting_s`: going
    on after the program's end, until the shaper is at rest and then holding.
    """
    plant = _plant(rig, plan, seed, temperature_C, heat_C)
    period_s = 1.0 / rig.loop.rate_Hz
    holding, count = round(holding_s / period_s), round((plan.program.duration_s + resting_s) / period_s)
    table = _cycles(rig, plan, plant, holding, count)
    assert rig.link_mode is not None
    return LineRun(plan, period_s, table[:, 0], table[:, 1], table[:, 2:4], table[:, 4:6], LinkFrequency(rig.link_mode))


def _plant(rig: Rig, plan: RunPlan, seed: int, temperature_C: float | None, heat_C: Floats | None) -> SimulatedRig:
    """The simulated rig at the run's start, as warm as was asked for."""
    plant = SimulatedRig(rig, seed)
    plant.reset(list(plan.start_position), temperature_C if heat_C is None else float(heat_C[-1]))
    if heat_C is not None:
        plant.state[H.RESERVOIR : H.OIL + 1] = heat_C
    return plant


def _cycles(rig: Rig, plan: RunPlan, plant: SimulatedRig, holding: int, count: int) -> Floats:
    """`holding` cycles of holding, then `count` cycles of which these are kept: true tip acceleration and deflection, both joints'
    references, both true positions."""
    controller, senses = Controller(rig), _Senses(rig, plant)
    controller.prepare(plan)
    period_s = 1.0 / rig.loop.rate_Hz
    ended = round((plan.program.duration_s + plan.flush_s) / period_s) + 1
    table = np.empty((count, 6))
    for cycle in range(-holding, count):
        mode = Mode.RUNNING if 0 <= cycle <= ended else Mode.HOLDING
        position, deflection, acceleration, oil = senses.read()
        out = controller.step(Inputs(cycle + holding, int(mode), plan.run, position, deflection, acceleration, oil))
        if cycle >= 0:
            tip = plant.true_signal("tip.acceleration"), plant.true_signal("tip.deflection")
            table[cycle] = (*tip, out.joints[0].reference, out.joints[1].reference, *plant.true_position)
        plant.advance([joint.command_V for joint in out.joints], period_s)
    return table


class _Senses:
    """Raw counts to values, as the daemon does it with the rig file's calibrations."""

    def __init__(self, rig: Rig, plant: SimulatedRig) -> None:
        self._plant = plant
        names = [f"{ROTARY}.position", f"{PRISMATIC}.position", "tip.deflection", "tip.acceleration"]
        if any(temperature_signals(rig)):
            names += [name or "" for name in temperature_signals(rig)]
        self._at = [plant.channels.index(name) if name in rig.signals else -1 for name in names]
        calibrations = [rig.signals[name].calibration if name in rig.signals else None for name in names]
        self._scale = [(c.offset, c.scale) if c is not None else (nan, nan) for c in calibrations]

    def read(self) -> tuple[tuple[float, float], float, float, tuple[float, ...]]:
        """Positions, tip deflection, tip acceleration, oil temperatures."""
        raw = self._plant.sense()
        values = [offset + scale * raw[at] for at, (offset, scale) in zip(self._at, self._scale, strict=True)]
        return (values[0], values[1]), values[2], values[3], tuple(values[4:])
