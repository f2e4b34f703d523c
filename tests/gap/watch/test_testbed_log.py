"""One log of the two-joint testbed, positions alone: a leak twice what the file says and more friction, all uncertain constants free."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from gap.data.measured import Measured, on_grid
from gap.fitting.nuisance import nuisances
from gap.watch.log_fit import fit_log
from gap.watch.watched import watched
from sim_backend.plant import SimulatedRig

WORN = {"rotary.cross_leakage.conductance": (4.45e-12, 8.9e-12), "rotary.coulomb_friction.friction": (105.0, 150.0)}


def measured(text: str, seed: int) -> Measured:
    """8 s of both valves moved by three sines each."""
    machine, draw, t = rig_from_text(text), np.random.default_rng(seed), 0.001 * np.arange(8000)

    def waves(volts: float) -> np.ndarray:
        found = sum(draw.uniform(0.5, 1) * np.sin(2 * np.pi * f * (t + draw.uniform(0, 3))) for f in draw.uniform(0.3, 1.5, 3))
        return np.asarray(volts * found)

    command_V = np.stack([waves(1.0), waves(0.6)], axis=1)
    plant = SimulatedRig(machine, seed)
    plant.reset([0.0, 1.0])
    raw = plant.run(command_V, 0.001, sense=True)["raw"]
    columns = {"t_s": t, "rotary.command_V": command_V[:, 0], "prismatic.command_V": command_V[:, 1]}
    assert machine.plant is not None
    for name in ("rotary.position", "prismatic.position"):
        columns[name] = raw[:, list(machine.plant.sensors).index(name)] * machine.signals[name].calibration.scale
    return on_grid(Path("testbed.csv"), columns, machine, "")


@pytest.mark.slow
def test_a_leak_shows_and_the_truths_are_within_their_intervals() -> None:
    loaded = load_rig("ornl_testbed")
    worn = loaded.text.replace("conductance: 4.45e-12", "conductance: 8.9e-12").replace("friction: 105 N*m", "friction: 150 N*m")
    found = fit_log(loaded, [measured(worn, 1)], 1)
    assert found.cost < 1.05
    truth = {number.name: number.free.start for number in watched(loaded.rig, nuisances(loaded, frozenset()))}
    truth |= {name: now for name, (_, now) in WORN.items()}
    held = [abs(value.value - truth[name]) < 1.96 * value.sd for name, value in found.values.items()]
    assert len(held) >= 12
    assert np.mean(held) > 0.8
    for name, (stated, _) in WORN.items():
        assert found.values[name].value - stated > 3.0 * found.values[name].sd
