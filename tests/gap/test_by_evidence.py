"""`find` with the evidence in the place of the gates: files, verdict, probabilities; a changed number is written as a constant."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from config.loading.load import load_rig, rig_from_text
from gap.find import find
from gap.search.settings import Settings
from tests.support.gap import axis_logs

QUIET = Settings(propose=False, decide="evidence")


def searched(folder: Path, file: str, true: str) -> dict[str, Any]:
    """findings.json of a search with the rig file `file` on logs of the machine `true`."""
    rig, machine = folder / "rig.yaml", rig_from_text(true)
    rig.write_text(file)
    logs = [axis_logs.write(folder / f"{k}.csv", axis_logs.simulated(machine, 31 + k, 8.0)) for k in (0, 1)]
    find(rig, logs[:1], logs[1:], folder / "out", lambda line: None, QUIET)
    content: dict[str, Any] = json.loads((folder / "out" / "findings.json").read_text())
    return content


@pytest.mark.slow
def test_a_rig_file_that_lacks_nothing_has_no_gap(tmp_path: Path) -> None:
    text = axis_logs.axis_text()
    found = searched(tmp_path, text, text)
    assert found["verdict"] == "no_gap"
    assert found["findings"] == []
    assert (tmp_path / "out" / "rig.yaml").read_text() == text


@pytest.mark.slow
def test_missing_friction_is_named_with_its_probability(tmp_path: Path) -> None:
    found = searched(tmp_path, axis_logs.axis_text("coulomb_friction"), axis_logs.axis_text())
    (item,) = found["findings"]
    assert (item["effect"], item["where"], item["confirmed"]) == ("coulomb_friction", "axis", True)
    assert item["probability"] > 0.99
    assert item["parameters"]["friction"]["value"] == pytest.approx(20.39, rel=0.02)
    assert "coulomb_friction" in (tmp_path / "out" / "rig.yaml").read_text()
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.slow
def test_friction_of_three_times_its_stated_size_is_found_as_changed(tmp_path: Path) -> None:
    text = axis_logs.axis_text()
    found = searched(tmp_path, text, text.replace("friction: 20.39 N", "friction: 61.17 N"))
    (item,) = found["findings"]
    assert (item["effect"], item["where"]) == ("coulomb_friction", "axis")
    assert item["stated"] == pytest.approx(20.39)
    assert item["value"] == pytest.approx(61.17, rel=0.02)
    plant = load_rig(str(tmp_path / "out" / "rig.yaml")).rig.plant
    assert plant is not None
    written = next(e for e in plant.effects if e.effect == "coulomb_friction")
    assert written.model_dump()["friction"] == pytest.approx(61.17, rel=0.02)
