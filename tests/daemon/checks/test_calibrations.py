"""Calibrations that end: told or refused at arming, as the rig file says; and raw counts in the log to which another can be applied."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.errors import ConfigError, DaemonError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from daemon.cli.shown.check_table import checks_lines
from daemon.lockstep import LockstepRig
from daemon.loop.command import LoopCommand
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.daemon.rigs import JOG, texts_of
from tests.support.daemon.simple_device import SimpleDevice, factory

SIGNALS = "signals.rotary.supply_pressure.calibration"
OIL = "signals.reservoir_temperature.calibration"


def calibrated(*records: str) -> LoadedRig:
    text = apply_overrides(load_rig("ornl_testbed").text, records)
    return LoadedRig(rig_from_text(text), text, "calibrated.yaml")


def lockstep(directory: Path, *records: str) -> LockstepRig:
    """The virtual clock begins on 2000-01-01."""
    made: list[SimpleDevice] = []
    return LockstepRig(calibrated(*records), directory, create=factory(made))


def test_an_expired_calibration_warns_in_why_and_in_the_log_and_lets_arm(tmp_path: Path) -> None:
    with lockstep(tmp_path, f"{SIGNALS}.valid_until=1999-12-30", f"{SIGNALS}.by=A. Tester; dead-weight") as rig:
        rig.arm()
        assert rig.mode is Mode.HOLDING
        (check,) = [check for check in rig.loop.keeper.checks if check.name == "rotary.supply_pressure calibration"]
        row = check.row(rig.loop.values)
        assert (row["ok"], row["severity"]) == (True, "warning")
        assert row["value"] == pytest.approx(-1.0, abs=0.01)
        assert "A. Tester" in row["source"]
        lines = checks_lines([row])
        assert lines[0].startswith("!!")
        assert "valid until 1999-12-30" in lines[1]
        assert lines[2].strip() == "docs/reference/checks.md#signal-calibration"
        assert "valid until 1999-12-30" in texts_of(rig, "check")[0]
        rig.disarm()
    log = read_log(rig.recorder.finished[0])
    assert any(event.name == "check" and "1999-12-30" in event.text for event in log.events)
    assert b'"valid_until": "1999-12-30"' in log.attachments["calibration.json"]


def test_an_expired_calibration_blocks_where_the_rig_file_says_so(tmp_path: Path) -> None:
    with lockstep(tmp_path, f"{OIL}.valid_until=1999-12-30", f"{OIL}.on_expiry=block") as rig:
        with pytest.raises(DaemonError, match=r"reservoir_temperature calibration .* -1 days left .*calibrate again"):
            rig.arm()
        assert rig.mode is Mode.DISARMED


def test_the_last_day_counts_to_its_end(tmp_path: Path) -> None:
    with lockstep(tmp_path, f"{OIL}.valid_until=2000-01-01", f"{OIL}.on_expiry=block") as rig:
        rig.arm()
        assert rig.mode is Mode.HOLDING
        assert rig.value("reservoir_temperature.calibration_days_left") == pytest.approx(1.0, abs=1e-3)


def test_an_expiry_while_armed_stops_nothing(tmp_path: Path) -> None:
    with lockstep(tmp_path, f"{OIL}.valid_until=2000-01-01", f"{OIL}.on_expiry=block") as rig:
        rig.arm()
        rig.loop._spare_watches.clear()
        rig.loop.values[rig.facts.index("reservoir_temperature.calibration_days_left")] = -1.0
        rig.start(JOG)
        rig.cycles(500)
        assert rig.mode is Mode.RUNNING
        rig.commands.post(LoopCommand(leave=True))
        rig.until(lambda: rig.loop.left, 3.0)
        assert rig.loop.keeper.run.reason == "the daemon ends"


def test_a_record_that_ends_before_it_begins_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"valid_until must not be before calibrated_on \(2026-05-01\)"):
        calibrated(f"{OIL}.calibrated_on=2026-05-01", f"{OIL}.valid_until=2026-04-01")


def test_the_uncertainty_has_the_unit_of_the_signal() -> None:
    signals = calibrated(f"{SIGNALS}.uncertainty=7.5 psi", f"{OIL}.uncertainty=0.5 K").rig.signals
    assert signals["rotary.supply_pressure"].calibration.uncertainty == pytest.approx(7.5 * 6894.757)
    assert signals["reservoir_temperature"].calibration.uncertainty == 0.5
    with pytest.raises(ConfigError, match="uncertainty"):
        calibrated(f"{OIL}.uncertainty=0.5 bar")


def test_another_calibration_can_be_applied_to_the_raw_counts_of_a_log(tmp_path: Path) -> None:
    with lockstep(tmp_path) as rig:
        rig.arm()
        rig.cycles(20)
        rig.disarm()
    columns = read_log(rig.recorder.finished[0]).columns
    for name, value in (("rotary.position", "rotary.position"), ("prismatic.supply_pressure", "prismatic.supply_pressure_Pa")):
        calibration = rig.rig.signals[name].calibration
        raw = columns[f"{name}_raw"]
        assert np.all(np.isfinite(raw))
        np.testing.assert_allclose(calibration.offset + calibration.scale * raw, columns[value], rtol=1e-12)
