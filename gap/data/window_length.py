"""How long the windows of a comparison are: as short as possible, so that one moment's error does not spoil the next and many windows vote,
but long enough that what matters moves the joint visibly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from config.schema.plant_joint import ForceActuator, TorqueActuator
from config.schema.rig import Rig
from gap.data.measured import Measured
from gap.data.windows import default_window_s

VISIBLE = 4.5  # standard deviations from which an effect counts as seen
LONGEST_S = 0.5
MATTERS = 0.01  # of the force that acted


def window_length_s(rig: Rig, logs: Sequence[Measured], sigma: Mapping[str, float]) -> float:
    """The default for a rig, longer for an electric drive whose position is too coarse for it.

    A hundredth of the root mean square force, acting all the time, bends the position by F t²/2M. What offset and slope of a window do
    not take up of that is F L²/(12 √5 M), root mean square; it must be as large as an effect must be to count as seen.
    """
    shortest = default_window_s(rig)
    joint = next(iter(rig.joints))
    drive = rig.plant.joints[joint] if rig.plant and len(rig.joints) == 1 else None
    if isinstance(drive, ForceActuator):
        gain, mass = abs(drive.gain_N_per_V), drive.mass_kg
    elif isinstance(drive, TorqueActuator):
        gain, mass = abs(drive.gain_N_m_per_V), drive.inertia_kg_m2
    else:
        return shortest
    acted_V = float(np.sqrt(np.mean(np.concatenate([log.commands_V[:, 0] ** 2 for log in logs]))))
    if gain * acted_V == 0.0:
        return shortest
    length = np.sqrt(12 * np.sqrt(5) * VISIBLE * sigma[f"{joint}.position"] * mass / (MATTERS * gain * acted_V))
    return round(float(np.clip(length, shortest, LONGEST_S)), 2)
