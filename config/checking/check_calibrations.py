"""What `longreach check` says about calibrations that run out: of sensors, and the record a rig file refers to."""

from __future__ import annotations

import datetime
from collections.abc import Iterator
from pathlib import Path

from config.checking.finding import Finding, error_at, warning_at
from config.loading.calibration_record import CalibrationRecord, load_record
from config.loading.identified import record_path
from config.loading.load import LoadedRig
from config.parsing.yaml_tree import YamlTree


def check_calibrations(loaded: LoadedRig, tree: YamlTree, today: datetime.date) -> Iterator[Finding]:
    """Which sensors' calibrations have run out, and whether the rig can be armed all the same."""
    for name, signal in loaded.rig.signals.items():
        until, day = signal.calibration.valid_until, signal.calibration.calibrated_on
        if signal.calibration.on_expiry == "block" and until is None:
            path = ("signals", name, "calibration", "on_expiry")
            yield warning_at(tree, path, f"{name}: on_expiry: block never blocks without valid_until")
        if day is not None and day > today:
            yield warning_at(tree, ("signals", name, "calibration", "calibrated_on"), f"{name}: calibrated_on {day} has not come yet")
        if until and until < today:
            blocks = signal.calibration.on_expiry == "block"
            what = f"{name}: the calibration was valid until {until}: calibrate again"
            path = ("signals", name, "calibration", "valid_until")
            yield error_at(tree, path, f"{what}; the rig cannot be armed") if blocks else warning_at(tree, path, what)


def check_identified(loaded: LoadedRig, tree: YamlTree, today: datetime.date) -> Iterator[Finding]:
    """Which numbers were identified, by whom, how sure and until when. (A missing record does not get here: load_rig refuses it.)"""
    reference = loaded.rig.identified
    if reference is None:
        return
    record = load_record(record_path(reference.record, Path(loaded.path)))
    yield Finding("ok", f"identified: {reference.record} of {record.identified_on} by {record.by} ({record.source}): {_numbers(record)}")
    if record.valid_until < today:
        text = f"identified: {reference.record} was valid until {record.valid_until}: run `longreach identify` again"
        yield warning_at(tree, ("identified", "record"), text)
    if record.source == "simulated" and any(device.driver != "sim" for device in loaded.rig.devices.values()):
        text = f"identified: {reference.record} was made on the simulated rig, but this file drives devices"
        yield warning_at(tree, ("identified", "record"), text)


def _numbers(record: CalibrationRecord) -> str:
    link = record.link
    if link is None:
        return "no link"
    damping = "" if link.damping_ratio is None else f", damping {link.damping_ratio:.4f}"
    return f"payload {link.payload_kg:.3f} ± {link.payload_uncertainty_kg:.3f} kg, {len(link.frequency_map)} extensions{damping}"
