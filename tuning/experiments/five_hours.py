"""Five hours of the machine's own work as the reference has them (the paper's Figure 2), in lockstep on the whole plant.

20 min idle, then cycles of 25 min: slow and large tests, fast and small ones, a pause. The tests are sines on both joints of the unloaded
arm, one frequency a minute, and as large as makes the flow that the reference states. Nothing is given to the heat stores but what the
valves take: spools, leakage and lands make the flow, control period by control period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle, islice
from math import pi

import numpy as np

from config.errors import PlantError
from config.progress import Progress
from config.schema.rig import Rig
from sim_backend.kernel.warm_up import warm_up
from sim_backend.memory.layout import C, H
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.experiments.sine_test import EXTENSION_M
from tuning.variants import plant_of, with_link

GPM = 6.30902e-5
MINUTE_S, FADE_S = 60, 1.0
HOURS = 5.0
START_C = 22.0


@dataclass(frozen=True, slots=True)
class Phase:
    """`flow_gpm`: what the reference states for both valves. Rates' amplitudes as shares of the joints' rate limits; frequencies go from
    one end of the band to the other in equal steps of the logarithm, one a minute."""

    minutes: int
    flow_gpm: float
    shares: tuple[float, float] = (0.0, 0.0)
    band_Hz: tuple[float, float] = (1.0, 1.0)


IDLE, PAUSE = Phase(20, 0.6), Phase(5, 0.6)
LARGE, FAST = Phase(12, 5.0, (0.75, 0.59), (0.25, 1.0)), Phase(8, 1.2, (0.18, 0.083), (2.0, 8.0))


@dataclass(frozen=True, slots=True, eq=False)
class FiveHours:
    """One value a second: valve flow (m³/s), temperatures (degC); `heat`: RESERVOIR to OIL of the plant's state, one array a moment
    that was asked for."""

    t_s: Floats
    flow: Floats
    reservoir_C: Floats
    supply_C: Floats
    return_C: Floats
    metal_C: Floats
    heat: tuple[Floats, ...]

    def stores_alone(self, rig: Rig, start_C: float) -> dict[str, Floats]:
        """The heat stores without the plant, fed with this flow."""
        return warm_up(rig, self.flow, 1.0, start_C)


def minutes(hours: float = HOURS) -> list[tuple[Phase, float]]:
    """Phase and test frequency (Hz) of every minute."""
    found = [(IDLE, 1.0)] * IDLE.minutes
    rounds = [(phase, frequency) for phase in (LARGE, FAST, PAUSE) for frequency in np.geomspace(*phase.band_Hz, phase.minutes).tolist()]
    found += list(islice(cycle(rounds), max(0, round(60.0 * hours) - len(found))))
    return found[: round(60.0 * hours)]


def stated_flow(hours: float = HOURS) -> Floats:
    """Valve flow every second as the reference states it, m³/s."""
    return np.repeat([phase.flow_gpm for phase, _ in minutes(hours)], MINUTE_S) * GPM


def five_hours(
    rig: Rig, moments_s: Sequence[float] = (), hours: float = HOURS, start_C: float = START_C, progress: Progress = lambda line: None
) -> FiveHours:
    """The whole plant through `hours` of the schedule, everything at `start_C` at first. `moments_s`: to the minute.

    Raises PlantError when the rig's plant has no thermal section or other joints than a rotary and a prismatic one.
    """
    plant = _plant(rig, start_C)
    servos = [[s.gain, s.velocity_feedforward, rig.joints[name].command_limit_V] for name, s in rig.servo.items()]
    wanted = sorted(round(moment / MINUTE_S) for moment in moments_s)
    heat = [_heat(plant)] * wanted.count(0)
    parts = []
    for minute, (phase, frequency_Hz) in enumerate(minutes(hours), 1):
        parts.append(plant.follow(_references(rig, phase, frequency_Hz), servos, 1.0 / rig.loop.rate_Hz, MINUTE_S))
        heat += [_heat(plant)] * wanted.count(minute)
        if minute % 30 == 0:
            progress(f"{minute / 60.0:.1f} h: reservoir {parts[-1]['reservoir_temperature'][-1]:.1f} °C")
    columns: list[Floats] = [np.concatenate([part[name] for part in parts]) for name in parts[0]]
    flow, reservoir, supply, back, metal = columns
    return FiveHours(np.arange(1.0, len(flow) + 1.0), flow, reservoir, supply, back, metal, tuple(heat))


def _plant(rig: Rig, start_C: float) -> SimulatedRig:
    section = plant_of(rig)
    if tuple(rig.joints) != ("rotary", "prismatic"):
        raise PlantError("the cycles are made for a rotary and a prismatic joint", value=", ".join(rig.joints), where=rig.name)
    plant = SimulatedRig(with_link(rig, payload_kg=0.0) if section.link is not None else rig)
    if plant.parameters.values[C.THERMAL] == 0.0:
        raise PlantError("the plant has no thermal section", where=rig.name, next_step="Add plant.thermal.")
    plant.reset([0.0, EXTENSION_M], start_C)
    return plant


def _heat(plant: SimulatedRig) -> Floats:
    return plant.state[H.RESERVOIR : H.OIL + 1].copy()


def _references(rig: Rig, phase: Phase, frequency_Hz: float) -> Floats:
    """One minute of both joints about their middle, fading in and out: positions, then rates."""
    t = np.arange(1.0, MINUTE_S * rig.loop.rate_Hz + 1.0) / rig.loop.rate_Hz
    omega = 2.0 * pi * frequency_Hz
    ramp = np.clip(np.minimum(t, MINUTE_S - t) / FADE_S, 0.0, 1.0)
    slope = np.where(t < FADE_S, 1.0, np.where(t > MINUTE_S - FADE_S, -1.0, 0.0)) / FADE_S
    wave, rate = ramp * np.sin(omega * t) / omega, ramp * np.cos(omega * t) + slope * np.sin(omega * t) / omega
    amplitudes = [share * joint.rate_limit for share, joint in zip(phase.shares, rig.joints.values(), strict=True)]
    return np.column_stack([amplitudes[0] * wave, EXTENSION_M + amplitudes[1] * wave, amplitudes[0] * rate, amplitudes[1] * rate])
