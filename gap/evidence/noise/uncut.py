"""Readings that a sensor's range has cut off: what is left beside them was chosen by its noise, and its mean is not the signal's.

A return line at next to no pressure is the everyday case: half of the noise is missing, the other half looks like back pressure. So where
a window holds a sample at the end of the range, it is not compared in that channel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from config.schema.rig import Rig
from gap.data.windows import Experiment


def uncut(experiment: Experiment, rig: Rig, channels: Sequence[str]) -> Experiment:
    """`channels`: names of the compared ones, in their order."""
    assert rig.plant is not None
    plan, measured = experiment.plan, experiment.measured.copy()
    rows = plan.starts[:, None] + np.arange(plan.rows)[None, :]
    for c, name in enumerate(channels):
        if name not in experiment.log.channels:
            continue
        values, sensor = experiment.log.channels[name].values, rig.plant.sensors[name]
        cut = (values <= sensor.low) | (values >= sensor.high)
        measured[cut[rows].any(axis=1), :, c] = np.nan
    return replace(experiment, measured=measured)
