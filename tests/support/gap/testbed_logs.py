"""What a simulated testbed gives for open-loop commands: its own readings of both positions, as a log in windows."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from config.schema.rig import Rig
from gap.data.measured import Array, on_grid
from gap.data.noise import noise_floors
from gap.data.windows import Experiment, prepare
from sim_backend.plant import SimulatedRig

CHANNELS = ["rotary.position", "prismatic.position"]


def experiment(machine: Rig, command_V: Array, seed: int, model: Rig, workers: int = 1) -> Experiment:
    """`command_V` (rows × joints, 1 kHz) on `machine` from 1 m of extension; windows of 0.4 s as `model` has them."""
    plant = SimulatedRig(machine, seed)
    plant.reset([0.0, 1.0])
    raw = plant.run(command_V, 0.001, sense=True)["raw"]
    sensors = list(machine.plant.sensors) if machine.plant else []
    columns = {"t_s": 0.001 * np.arange(len(command_V)), "rotary.command_V": command_V[:, 0], "prismatic.command_V": command_V[:, 1]}
    for name in CHANNELS:
        columns[name] = raw[:, sensors.index(name)] * machine.signals[name].calibration.scale
    log = on_grid(Path("testbed.csv"), columns, model, "")
    return prepare(log, model, noise_floors([log], model), 0.4, CHANNELS, workers)
