"""Logs of a simulated servo axis as CSV files, for tests; the commands are open loop, so two seeds are two maneuvers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from sim_backend.plant import SimulatedRig

PERIOD_S = 0.001
Columns = dict[str, np.ndarray]


def axis_text(*without: str, noise_um: float = 2.0) -> str:
    """force_axis with a noisy encoder, without some effects."""
    text = load_rig("force_axis").text.replace("{resolution: 1 um, ", f"{{resolution: 1 um, noise: {noise_um} um, ")
    return "".join(line for line in text.splitlines(keepends=True) if not any(f"effect: {name}," in line for name in without))


def axis_rig(*without: str) -> Rig:
    return rig_from_text(axis_text(*without))


def simulated(rig: Rig, seed: int, duration_s: float = 12.0, period_s: float = PERIOD_S, amplitude: float = 1.0) -> Columns:
    """Back and forth with a seed's frequencies; stays within the travel. `amplitude` scales the command."""
    t = period_s * np.arange(round(duration_s / period_s))
    draw = np.random.default_rng(seed)
    waves = (draw.uniform(0.9, 1.6) * np.sin(2 * np.pi * f * (t + draw.uniform(0, 3))) for f in draw.uniform(0.7, 2.2, 3))
    command = 0.09 + amplitude * sum(waves)
    plant = SimulatedRig(rig, seed)
    plant.reset([0.12])
    raw = plant.run(command[:, None], period_s, sense=True)["raw"]
    return {"t_s": t, "axis.position": raw[:, 0] * 1e-6, "axis.command_V": command}


def write(path: Path, columns: Columns, change: Callable[[Columns], Columns] | None = None) -> Path:
    """One CSV; `change` spoils it."""
    columns = change(dict(columns)) if change else columns
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    return path
