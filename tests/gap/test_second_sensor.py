"""A second sensor of a joint's motion is one more channel compared: it tells a late encoder from a late command, as one cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, rig_from_text
from config.schema.rig import Rig
from gap.data.measured import Measured, on_grid
from gap.find import search_gap
from gap.settings import Settings
from sim_backend.plant import SimulatedRig
from tests.support.gap import axis_logs

SENSOR = "    axis.second_position: {resolution: 1 um, noise: 2 um, low: -0.10 m, high: 0.35 m}\n"
LATE = "    - {effect: sensor_delay, where: sensor:axis.position, delay: 4 ms}\n"


def twice(text: str) -> str:
    """The sensor in the plant section."""
    return text.replace("  effects:\n", SENSOR + "  effects:\n")


def measured(machine: Rig, model: Rig, seed: int) -> Measured:
    columns = axis_logs.simulated(machine, seed)
    plant = SimulatedRig(machine, seed)
    plant.reset([0.12])
    raw = plant.run(columns["axis.command_V"][:, None], axis_logs.PERIOD_S, sense=True)["raw"]
    columns["axis.second_position"] = raw[:, plant.channels.index("axis.second_position")] * 1e-6
    np.testing.assert_array_equal(columns["axis.position"], raw[:, 0] * 1e-6)
    return on_grid(Path(f"log{seed}.csv"), columns, model, str(seed))


@pytest.mark.slow
def test_a_late_encoder_beside_one_that_is_not_is_named_alone() -> None:
    text = twice(axis_logs.axis_text())
    loaded, machine = LoadedRig(rig_from_text(text), text, "axis.yaml"), rig_from_text(text + LATE)
    logs = [measured(machine, loaded.rig, seed) for seed in (11, 12)]
    assert logs[0].channels["axis.second_position"].unit == "m"
    found = search_gap(loaded, logs[:1], logs[1:], lambda line: None, Settings(propose=False))
    assert (found.verdict.word, found.verdict.confirmed) == ("named", True)
    (name,) = found.content["findings"]
    assert (name["effect"], name["where"], name["look_alikes"]) == ("sensor_delay", "sensor:axis.position", [])
    assert name["parameters"]["delay"]["value"] == pytest.approx(0.004, rel=0.02)
    assert "axis.second_position" in found.content["gap"]["channels"]
