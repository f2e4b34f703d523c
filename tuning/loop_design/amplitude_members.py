"""The rotary joint at given amplitudes as members of a design's family: describing responses measured by sine tests on the simulated rig.

Friction, the orifices' square root and the rounded null make gain and lag depend on the amplitude; the linearised plant without
friction has none of this.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from config.schema.rig import Rig
from tuning.experiments.sine_test import rotary, velocity_response
from tuning.loop_design.lag_lead_design import PlantResponse
from tuning.loop_design.measured_plant import MeasuredPlant
from tuning.variants import ROTARY, plant_of

AMPLITUDES_V = (0.1, 0.3, 1.0, 3.0)  # of the paper's valve; of another one the same openings
PAPER_FULL_SCALE_V = 9.08
TESTED_HZ = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0)


def amplitude_members(rig: Rig, delay_s: float, extension_m: float, pace: float = 1.0) -> tuple[PlantResponse, ...]:
    """One member for each amplitude, with dead time, of the empty arm at an extension; `pace`: times as fast as the paper's joint."""
    tested_Hz = pace * np.array(TESTED_HZ)
    found = []
    for volts in amplitudes_V(rig):
        response = velocity_response(rig, replace(rotary(), extension_m=extension_m), volts, tested_Hz.tolist())
        found.append(MeasuredPlant(volts, tested_Hz, np.log(np.abs(response)), np.unwrap(np.angle(response)), delay_s))
    return tuple(found)


def amplitudes_V(rig: Rig) -> tuple[float, ...]:
    """What opens the rig's rotary valve as far as AMPLITUDES_V the paper's."""
    full_scale_V = getattr(getattr(plant_of(rig).joints[ROTARY], "valve", None), "full_scale_V", PAPER_FULL_SCALE_V)
    return tuple(volts * (full_scale_V / PAPER_FULL_SCALE_V) for volts in AMPLITUDES_V)
