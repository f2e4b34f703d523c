"""Faults of the data that show beside the simulation: swapped chambers, units, sign, lag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from gap.data.channel_check import DataProblem
from gap.data.measured import on_grid
from gap.data.noise import noise_floors
from gap.data.windows import prepare
from gap.find import search_gap
from gap.fitting.evaluation import evaluate
from gap.fitting.model import Model
from gap.fitting.model_check import against_model
from gap.settings import Settings
from sim_backend.plant import SimulatedRig

Columns = dict[str, np.ndarray]
PERIOD_S = 0.002


@pytest.fixture(scope="module")
def arm() -> tuple[Rig, Columns]:
    """The testbed with chamber pressures at the rotary joint, moved open loop; noise on every channel."""
    sensors = "".join(f"    rotary.pressure_{k}: {{resolution: 100 Pa, noise: 5 kPa, low: 0 Pa, high: 30 MPa}}\n" for k in "ab")
    rig = rig_from_text(load_rig("ornl_testbed").text.replace("  sensors:\n", "  sensors:\n" + sensors, 1))
    t = PERIOD_S * np.arange(4000)
    commands = np.column_stack([0.9 * np.sin(2 * np.pi * 0.61 * t) + 0.4 * np.sin(2 * np.pi * 2.3 * t), 0.5 * np.sin(2 * np.pi * 0.17 * t)])
    run = SimulatedRig(rig).run(commands, PERIOD_S)
    draw = np.random.default_rng(5)
    noise = {
        "rotary.position": 1e-4,
        "prismatic.position": 1e-5,
        "rotary.pressure_a": 5e3,
        "rotary.pressure_b": 5e3,
        "tip.deflection": 1e-5,
    }
    measured = {name: run[name] + sd * draw.normal(size=t.size) for name, sd in noise.items()}
    fields = {
        "rotary.pressure_a": "rotary.pressure_a_Pa",
        "rotary.pressure_b": "rotary.pressure_b_Pa",
        "tip.deflection": "tip.deflection_m",
    }
    columns = {fields.get(name, name): values for name, values in measured.items()}
    return rig, columns | {"t_s": t, "rotary.command_V": commands[:, 0], "prismatic.command_V": commands[:, 1]}


def problems(arm: tuple[Rig, Columns], change: Callable[[Columns], Columns]) -> list[DataProblem]:
    rig, columns = arm
    log = on_grid(Path("arm.csv"), change(dict(columns)), rig, "")
    names = list(log.channels)
    experiment = prepare(log, rig, noise_floors([log], rig), 0.4, names, 1)
    return against_model([evaluate(experiment, Model(rig, (), np.empty(0)), None)], names)


def test_a_good_log_is_not_suspected(arm: tuple[Rig, Columns]) -> None:
    assert problems(arm, lambda c: c) == []


def test_swapped_chambers(arm: tuple[Rig, Columns]) -> None:
    a, b = "rotary.pressure_a_Pa", "rotary.pressure_b_Pa"
    (found,) = [p for p in problems(arm, lambda c: c | {a: c[b], b: c[a]}) if p.fatal]
    assert found.channel == "rotary.pressure_a"
    assert "fits the simulation of rotary.pressure_b and the other way round, t = 0.000 to 7.998 s: swapped channels" in found.what


@pytest.mark.parametrize(("factor", "unit"), [(39.37008, "inches for metres"), (1e3, "millimetres for metres")])
def test_a_wrong_unit(arm: tuple[Rig, Columns], factor: float, unit: str) -> None:
    found = [p for p in problems(arm, lambda c: c | {"rotary.pressure_b_Pa": factor * c["rotary.pressure_b_Pa"]}) if p.fatal]
    assert [p.channel for p in found] == ["rotary.pressure_b"]
    assert found[0].what.endswith(f"{unit}?")


def test_a_reversed_sensor_is_left_to_the_search(arm: tuple[Rig, Columns]) -> None:
    found = problems(arm, lambda c: c | {"rotary.pressure_a_Pa": 2e7 - c["rotary.pressure_a_Pa"]})
    assert any(p.channel == "rotary.pressure_a" and "moves against the simulation" in p.what and not p.fatal for p in found)


def test_a_late_sensor_is_measured_and_left_to_the_search(arm: tuple[Rig, Columns]) -> None:
    def late(c: Columns) -> Columns:
        return c | {"rotary.pressure_a_Pa": np.concatenate([np.full(15, c["rotary.pressure_a_Pa"][0]), c["rotary.pressure_a_Pa"][:-15]])}

    (found,) = [p for p in problems(arm, late) if p.channel == "rotary.pressure_a"]
    assert "late against the simulation" in found.what
    assert float(found.what.split()[1]) == pytest.approx(30, abs=4)
    assert not found.fatal


def rod(seed: int) -> Columns:
    """The seal rig without friction: a moving rod, the chamber's pressure swings, the load cell follows it."""
    t, draw = 0.01 * np.arange(800), np.random.default_rng(seed)
    pressure = 3e5 + 1e5 * np.sin(2 * np.pi * (0.4 + 0.1 * seed) * t) + 100 * draw.normal(size=t.size)
    position = -0.02 + 0.01 * np.sin(2 * np.pi * 0.3 * seed * t)
    return {"t_s": t, "rod.position": position, "rod.pressure_a_Pa": pressure, "rod.command_V": 491e-6 * pressure}


def test_the_verdict_is_data_problem_and_the_rig_file_stays() -> None:
    """Pounds per square inch where the log says pascals, within the range of the gauge."""
    loaded = load_rig("seal_rig")
    columns = [rod(seed) for seed in (1, 2)]
    logs = [
        on_grid(Path(f"log{k}.csv"), c | {"rod.pressure_a_Pa": c["rod.pressure_a_Pa"] / 6894.757}, loaded.rig, str(k))
        for k, c in enumerate(columns)
    ]
    found = search_gap(loaded, logs[:1], logs[1:], lambda line: None, Settings(propose=False))
    assert found.content["verdict"] == "data_problem"
    assert "rod.pressure_a: its changes are 0.0001449 times what the plant predicts, from t = 0.000 to 7.990 s" in found.content["why"]
    assert "psi for pascals" in found.content["why"]
    assert found.content["findings"] == []
    assert found.improved_text == loaded.text
