"""`find` on a simulated axis: files, verdict, probabilities; a changed number is written as a constant, and all constants with what both
logs say of them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.schema.rig import Rig
from gap.data.experiments import experiments_of
from gap.data.measured import load
from gap.find import find
from gap.fitting.evaluation import evaluate, mean_cost
from gap.fitting.model import Model
from gap.settings import Settings
from tests.support.gap import axis_logs
from tests.support.gap.findings_schema import problems

QUIET = Settings(propose=False)


def searched(folder: Path, file: str, true: str) -> dict[str, Any]:
    """findings.json of a search with the rig file `file` on logs of the machine `true`."""
    rig = folder / "rig.yaml"
    rig.write_text(file)
    logs = recorded(folder, true)
    find(rig, logs[:1], logs[1:], folder / "out", lambda line: None, QUIET)
    return found_in(folder / "out")


def recorded(folder: Path, true: str) -> list[Path]:
    machine = rig_from_text(true)
    return [axis_logs.write(folder / f"{k}.csv", axis_logs.simulated(machine, 31 + k, 8.0)) for k in (0, 1)]


def found_in(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "findings.json").read_text())
    assert problems(content) == []
    return content


def half_width(item: dict[str, Any]) -> float:
    return 0.5 * float(item["ci95"][1] - item["ci95"][0])


def cost_of_hold_out(folder: Path, rig: Rig) -> float:
    """Of a rig file's text alone, with nothing of the search."""
    logs = [load(folder / f"{k}.csv", rig) for k in (0, 1)]
    _, _, held = experiments_of(LoadedRig(rig, "", ""), logs[:1], logs[1:], QUIET)
    return mean_cost([evaluate(e, Model(rig, (), np.empty(0)), None) for e in held])


@pytest.mark.slow
def test_a_rig_file_that_lacks_nothing_has_no_gap(tmp_path: Path) -> None:
    text = axis_logs.axis_text()
    found = searched(tmp_path, text, text)
    assert found["verdict"] == "no_gap"
    assert found["findings"] == []
    assert (tmp_path / "out" / "rig.yaml").read_text() == text
    sizes = {(row["effect"], row["where"]): row for row in found["not_seen"]}
    assert 0.0 < sizes["valve_deadband", "axis"]["smallest_visible"] < 0.02
    friction = sizes["coulomb_friction", "axis"]  # which the file has: a change
    assert friction["stated"] == 20.39
    assert 0.0 < friction["smallest_visible"] < 20.39


@pytest.mark.slow
def test_missing_friction_is_named_with_its_probability(tmp_path: Path) -> None:
    found = searched(tmp_path, axis_logs.axis_text("coulomb_friction"), axis_logs.axis_text())
    (item,) = found["findings"]
    assert (item["effect"], item["where"], item["confirmed"]) == ("coulomb_friction", "axis", True)
    assert item["probability"] > 0.99
    assert item["votes"]["holdout"] > 100.0  # the whole gap is this friction, in either log
    assert item["votes"]["fit_logs"] > 100.0
    assert item["parameters"]["friction"]["value"] == pytest.approx(20.39, rel=0.02)
    assert "coulomb_friction" in (tmp_path / "out" / "rig.yaml").read_text()
    assert (tmp_path / "out" / "report.html").exists()


def three_times_the_friction(folder: Path) -> dict[str, Any]:
    text = axis_logs.axis_text()
    return searched(folder, text, text.replace("friction: 20.39 N", "friction: 61.17 N"))


@pytest.mark.slow
def test_two_logs_know_a_changed_number_better_than_one(tmp_path: Path) -> None:
    (item,) = three_times_the_friction(tmp_path)["findings"]
    of_all = item["parameters"]["friction"]
    assert half_width(of_all) < 0.9 * half_width(of_all["fit_logs"])  # of two logs that say as much: 0.71


@pytest.mark.slow
def test_friction_of_three_times_its_stated_size_is_found_as_changed(tmp_path: Path) -> None:
    found = three_times_the_friction(tmp_path)
    (item,) = found["findings"]
    assert (item["effect"], item["where"]) == ("coulomb_friction", "axis")
    assert item["stated"] == pytest.approx(20.39)
    assert item["value"] == pytest.approx(61.17, rel=0.02)
    rig = load_rig(str(tmp_path / "out" / "rig.yaml")).rig
    plant = rig.plant
    assert plant is not None
    written = next(e for e in plant.effects if e.effect == "coulomb_friction")
    assert written.model_dump()["friction"] == pytest.approx(item["value"])
    of_all = item["parameters"]["friction"]
    assert of_all["value"] == item["value"]
    assert of_all["ci95"][0] < 61.17 < of_all["ci95"][1]
    assert half_width(of_all) < half_width(of_all["fit_logs"])
    assert found["gap"]["holdout_all_logs"] == pytest.approx(cost_of_hold_out(tmp_path, rig), rel=0.05)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "by the fit logs alone" in page
    assert "with constants fitted to all logs" in page
