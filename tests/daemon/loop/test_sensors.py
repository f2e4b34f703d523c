"""Sensors that fail, go silent or say what cannot be: which reaction, in which cycle."""

from __future__ import annotations

from math import inf, isfinite, isnan, nan
from pathlib import Path

import pytest

from daemon.modes.mode_machine import OperatorAction
from daemon.modes.run_watch import RunVerdict
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, MS, simple_rig, texts_of


@pytest.mark.parametrize("signal", ["rotary.position", "prismatic.position", "rotary.supply_pressure", "tip.acceleration"])
def test_nan_in_a_required_sensor_is_a_fault_with_safe_outputs_in_that_cycle(tmp_path: Path, signal: str) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        assert rig.mode is Mode.RUNNING
        device.override[signal] = nan
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert device.verbs[-1] == "safe"
        assert signal in texts_of(rig, "fault")[0]
        assert rig.loop.keeper.run.verdict is RunVerdict.INVALID
        device.override.clear()
        rig.cycles(50)
        assert rig.mode is Mode.FAULT, "latched although the sensor is back"
        rig.post(OperatorAction.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED


def test_infinite_values_are_no_numbers_either(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["rotary.position"] = inf
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None


@pytest.mark.parametrize("said", [{"raw": None}, {"raw": "7"}, {"raw": [1.0]}, {"quality": "good"}, {"quality": None}], ids=str)
@pytest.mark.parametrize("stale", [False, True])
def test_what_is_no_number_is_a_fault_that_names_its_device(said: dict[str, object], stale: bool, tmp_path: Path) -> None:
    """A plug-in may hand over anything. A stale sample is not scaled, and yet its count goes into the log."""
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.handed["rotary.position"] = said
        device.age_ns["rotary.position"] = 1_000_000_000 * stale
        rig.cycles(3)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert "devices.plant: TypeError" in rig.loop.keeper.why_fault


@pytest.mark.parametrize("ahead_s", [1.0, 1.8e9], ids=["a second", "the clock on the wall"])
def test_a_sample_stamped_ahead_is_no_fresh_one(ahead_s: float, tmp_path: Path) -> None:
    """By the stamps of another clock a device that has gone silent would never be found out."""
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.age_ns["rotary.position"] = -round(ahead_s * 1e9)
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert "rotary.position age" in " ".join(texts_of(rig, "fault"))


def test_nan_in_a_sensor_that_is_not_required_changes_nothing(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["tip.deflection"] = nan
        rig.cycles(10)
        assert rig.mode is Mode.HOLDING


def test_a_frozen_sensor_that_is_not_required_steers_no_more_than_one_that_is_gone(tmp_path: Path) -> None:
    """The last sample of a deflection sensor, good and ever older: the feedback fades out as without it."""
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["tip.deflection"] = 0.01
        rig.cycles(1000)
        steered = rig.value("tip.correction_rad")
        assert abs(steered) > 1e-3
        device.age_ns["tip.deflection"] = 10 * MS
        rig.cycles(1)
        assert isfinite(rig.value("tip.deflection_m")), "as old as allowed"
        device.age_ns["tip.deflection"] = 60_000 * MS
        rig.cycles(1)
        assert isnan(rig.value("tip.deflection_m"))
        assert isfinite(rig.value("tip.deflection_raw"))
        rig.cycles(300)
        assert rig.mode is Mode.HOLDING
        assert abs(rig.value("tip.correction_rad")) < 1e-3 * abs(steered)


@pytest.mark.parametrize(
    ("signal", "value", "check", "after"),
    [
        ("rotary.supply_pressure", 9e6, "rotary.supply_pressure limit", Mode.HOLDING),
        ("prismatic.supply_pressure", 5e6, "prismatic.supply_pressure lost", Mode.FAULT),
        ("rotary.supply_pressure", 17e6, "rotary.supply_pressure limit", Mode.HOLDING),
        ("prismatic.return_pressure", 2e6, "prismatic.return_pressure limit", Mode.HOLDING),
        ("reservoir_temperature", 66.0, "reservoir_temperature limit", Mode.HOLDING),
        ("reservoir_temperature", 9.0, "reservoir_temperature limit", Mode.HOLDING),
        ("tip.acceleration", -45.0, "tip.acceleration limit", Mode.HOLDING),
        ("rotary.supply_pressure", -1e6, "rotary.supply_pressure range", Mode.FAULT),
        ("rotary.position", 0.3, "rotary position rate", Mode.FAULT),
        ("reservoir_temperature", 200.0, "reservoir_temperature range", Mode.FAULT),
    ],
)
def test_interlocks_stop_or_fault_and_say_which(tmp_path: Path, signal: str, value: float, check: str, after: Mode) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(400)
        device.override[signal] = value
        rig.until(lambda: rig.mode not in (Mode.RUNNING, Mode.STOPPING), 3.0)
        assert rig.mode is after
        run = rig.loop.keeper.run
        assert run.verdict is RunVerdict.INVALID
        assert check in run.reason
        assert "limit" in run.reason
        rig.cycles(3)
        assert rig.loop.keeper.checks


def test_a_stale_sensor_is_a_fault_although_its_last_value_was_fine(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.age_ns["prismatic.position"] = 5 * MS
        rig.cycles(2)
        assert rig.mode is Mode.HOLDING, "as old as allowed"
        device.age_ns["prismatic.position"] = 5 * MS + 1000
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert "prismatic.position age" in rig.loop.keeper.why_fault
