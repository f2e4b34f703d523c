"""Temperatures over whole logs: the same heat stores agree, a reservoir of another size does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from gap.data.measured import Measured, on_grid
from gap.data.noise import noise_floors
from gap.data.windows import prepare
from gap.fitting.model import Model
from gap.fitting.temperatures import Warming, warmings
from sim_backend.plant import SimulatedRig

PERIOD_S = 0.005
FIELDS = {"reservoir_temperature": "reservoir_temperature_C", "rotary.return_temperature": "rotary.return_temperature_C"}


def rig(times: float = 1.0) -> Rig:
    """The testbed with a reservoir so small that it warms within seconds."""
    text = load_rig("ornl_testbed").text
    line = next(line for line in text.splitlines() if "reservoir_capacity:" in line)
    return rig_from_text(text.replace(line, f"    reservoir_capacity: {3000 * times} J/K"))


@pytest.fixture(scope="module")
def log() -> Measured:
    t = PERIOD_S * np.arange(4000)
    commands = np.column_stack([1.5 * np.sin(2 * np.pi * 0.4 * t), 0.8 * np.sin(2 * np.pi * 0.2 * t)])
    truth = rig()
    run = SimulatedRig(truth).run(commands, PERIOD_S)
    noise = 0.05 * np.random.default_rng(2).normal(size=(2, t.size))
    columns = {field: run[name] + noise[k] for k, (name, field) in enumerate(FIELDS.items())}
    columns |= {name: run[name] for name in ("rotary.position", "prismatic.position")}
    columns |= {"t_s": t, "rotary.command_V": commands[:, 0], "prismatic.command_V": commands[:, 1]}
    return on_grid(Path("warm.csv"), columns, truth, "")


def compared(model: Rig, log: Measured) -> dict[str, Warming]:
    names = list(log.channels)
    experiment = prepare(log, model, noise_floors([log], model), 0.4, names, 1)
    return {w.channel: w for w in warmings([experiment], Model(model, (), np.empty(0)).vector(), model)}


def test_temperatures_take_no_part_in_the_windows(log: Measured) -> None:
    assert set(log.temperatures) == set(FIELDS)
    assert not set(log.channels) & set(FIELDS)


def test_the_true_heat_stores_agree(log: Measured) -> None:
    found = compared(rig(), log)
    assert set(found) == set(FIELDS)
    reservoir = found["reservoir_temperature"]
    assert reservoir.measured_K > 1.0
    assert reservoir.simulated_K == pytest.approx(reservoir.measured_K, abs=0.1)
    assert all(w.agrees for w in found.values())
    assert abs(reservoir.offset_K) < 0.5


def test_a_reservoir_five_times_as_large_warms_too_slowly(log: Measured) -> None:
    reservoir = compared(rig(5.0), log)["reservoir_temperature"]
    assert reservoir.simulated_K < 0.3 * reservoir.measured_K
    assert not reservoir.agrees
    assert "changes by" in reservoir.text()
    assert reservoir.as_dict()["agrees"] is False
