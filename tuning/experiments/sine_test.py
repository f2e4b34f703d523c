"""Open-loop sine tests on the simulated rig: first harmonic of a joint's velocity over amplitude, frequency and temperature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, degrees, pi

import numpy as np

from config.schema.rig import Rig
from sim_backend.memory.layout import C
from sim_backend.plant import SimulatedRig
from tuning.arrays import Complexes, Floats
from tuning.transfer import EQ4
from tuning.variants import ROTARY, with_link

PERIOD_S = 0.25e-3  # short, so that the hold's own lag (0.1° at 2 Hz, 0.7° at 15 Hz) does not show
SETTLING_S, SETTLING_PERIODS = 1.5, 3
MEASURED_S, MEASURED_PERIODS = 1.0, 3
EXTENSION_M = 36 * 0.0254  # mid stroke of the paper's arm; the unloaded arm has 13 kg·m² there


@dataclass(frozen=True, slots=True)
class SineTest:
    """Which joint, how loaded. `payload_kg`: 0 for the rotary joint, whose paper model is of the unloaded arm."""

    joint: str
    payload_kg: float
    temperature_C: float | None = None
    extension_m: float = EXTENSION_M


def velocity_response(rig: Rig, test: SineTest, amplitude_V: float, frequencies_Hz: Sequence[float]) -> Complexes:
    """First harmonic of velocity over command (rad/s or m/s per V) for a sine of this amplitude; the link does not bend."""
    return np.array([_one(rig, test, amplitude_V, frequency) for frequency in frequencies_Hz])


def _one(rig: Rig, test: SineTest, amplitude_V: float, frequency_Hz: float) -> complex:
    plant = SimulatedRig(with_link(rig, payload_kg=test.payload_kg))
    values = plant.parameters.values
    values[C.BENDING_STIFFNESS], values[C.THERMAL] = 0.0, 0.0
    plant.reset([0.0, test.extension_m], test.temperature_C)
    settling = max(SETTLING_PERIODS, ceil(SETTLING_S * frequency_Hz))
    measured = max(MEASURED_PERIODS, ceil(MEASURED_S * frequency_Hz))
    samples = round((settling + measured) / frequency_Hz / PERIOD_S)
    window = round(measured / frequency_Hz / PERIOD_S)
    t = PERIOD_S * np.arange(samples)
    column = plant.joints.index(test.joint)
    commands = np.zeros((samples, len(plant.joints)))
    commands[:, column] = amplitude_V * np.cos(2.0 * pi * frequency_Hz * t)
    velocity = plant.run(commands, PERIOD_S)[f"{test.joint}.velocity"][-window:]
    turn = np.exp(-2j * pi * frequency_Hz * (t[-window:] - 0.5 * PERIOD_S))  # the held command lags by half a sample
    return complex(2.0 * np.mean(velocity * turn) / amplitude_V)


def relative_to_eq4(frequencies_Hz: Sequence[float], response: Complexes) -> tuple[Floats, Floats]:
    """(dB, degrees) of a rotary velocity response relative to Eq 4 of the paper taken in degrees per volt."""
    s = 2j * pi * np.asarray(frequencies_Hz)
    return decibels(degrees(1.0) * response / (EQ4(s) * s))


def decibels(ratio: Complexes) -> tuple[Floats, Floats]:
    return 20.0 * np.log10(np.abs(ratio)), np.degrees(np.angle(ratio))


def rotary(temperature_C: float | None = None) -> SineTest:
    """The rotary joint of the unloaded arm."""
    return SineTest(ROTARY, 0.0, temperature_C)
