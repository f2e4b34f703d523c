"""`status` shows every signal that the rig's drivers measure, in the units of the rig file."""

from __future__ import annotations

import re
from typing import Any

import pytest

from config.loading.load import load_rig
from daemon.cli.operate.status_commands import readings_view
from daemon.lockstep import LockstepRig
from daemon.server.live_values import units_answer
from daemon.server.stated_values import Units, units_from
from tests.support.daemon.lockstep_requests import LockstepRequests

PA_PER_PSI = 6894.757


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Units]:
    """The testbed's status after a third of a second, and how its file states what is SI."""
    loaded = load_rig("ornl_testbed")
    with LockstepRig(loaded, tmp_path_factory.mktemp("logs")) as rig:
        rig.cycles(300)
        lockstep = LockstepRequests(rig, loaded.text)
        status = lockstep.view.status(lockstep.values(), 1.0, lockstep.history)
    return status, units_from(units_answer(loaded.rig, [], loaded.text))


def test_every_signal_of_the_rig_has_a_value_and_its_si_unit(seen: tuple[dict[str, Any], Units]) -> None:
    readings, rig = seen[0]["readings"], load_rig("ornl_testbed").rig
    assert list(readings) == list(rig.signals)
    assert all(reading["value"] == reading["value"] for reading in readings.values())  # no NaN
    plant = rig.plant
    assert plant is not None
    assert plant.supply is not None
    supply = readings["rotary.supply_pressure"]
    assert supply["unit"] == "Pa"
    assert supply["value"] == pytest.approx(plant.supply.pressure_Pa, rel=0.05)


def test_a_line_for_every_place_in_the_units_of_the_file(seen: tuple[dict[str, Any], Units]) -> None:
    status, units = seen
    lines = {line.partition(":")[0]: line for line in readings_view(status, units)}
    assert {"rotary", "prismatic", "tip"} <= set(lines)
    found = re.search(r"supply pressure ([\d.]+) psi", lines["rotary"])
    assert found
    assert float(found[1]) * PA_PER_PSI == pytest.approx(status["readings"]["rotary.supply_pressure"]["value"], rel=1e-2)
    assert "position" not in lines["rotary"]  # stands in the table of joints


def test_in_si_unknown_values_are_dashes_and_an_older_daemon_has_no_lines(seen: tuple[dict[str, Any], Units]) -> None:
    status = seen[0]
    unknown = status | {"readings": {"tip.acceleration": {"value": None, "unit": "m/s^2"}}}
    assert readings_view(unknown, {}) == ["tip: acceleration –"]
    assert readings_view({"joints": {}}, {}) == []
