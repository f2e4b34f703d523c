"""A calibration as it stands in the rig file: `signals.NAME.calibration` with its day, its end, who made it, and its uncertainty."""

from __future__ import annotations

import datetime
import json

from config.loading.overrides import apply_overrides
from config.parsing.yaml_tree import entry, parse
from config.schema.signals import Calibration
from config.stated_sentences import Conversion
from tuning.sensor_calibration.line_fit import SensorCalibration

_DIGITS = 9


def calibration_entry(
    found: SensorCalibration, shown: Conversion, before: Calibration, today: datetime.date, valid_days: int, by: str
) -> str:
    """One line of YAML, in the unit in which the file states the signal. What an expiry does stays as it was."""
    unit, factor, zero = shown
    noise = f"noise {factor * found.noise:.3g} {unit}" if found.noise_is_known else "noise not measured"
    points = f"{len(found.points)} points, residual {factor * found.worst_residual:.3g} {unit}, {noise}"
    parts = {
        "scale": f"{factor * found.scale:.{_DIGITS}g} {unit}",
        "offset": f"{factor * found.offset + zero:.{_DIGITS}g} {unit}",
        "calibrated_on": str(today),
        "valid_until": str(today + datetime.timedelta(days=valid_days)),
        "by": json.dumps(f"{by}: {points}", ensure_ascii=False),
        **({"uncertainty": f"{factor * found.uncertainty:.3g} {unit}"} if found.uncertainty is not None else {}),
        "on_expiry": before.on_expiry,
    }
    return "{" + ", ".join(f"{key}: {value}" for key, value in parts.items()) + "}"


def with_calibration(text: str, signal: str, calibration: str) -> str:
    """The rig text with this calibration of a signal; a comment behind the old one goes with it, all others stay."""
    changed = apply_overrides(text, [f"signals.{signal}.calibration={calibration}"])
    found = entry(parse(changed, "rig.yaml").root, "signals")
    for part in (signal, "calibration"):
        assert found is not None
        found = entry(found[1], part)
    assert found is not None
    end = found[1].end_mark.index
    line_end = changed.find("\n", end)
    rest = changed[end : line_end if line_end >= 0 else len(changed)]
    if rest.strip().startswith("#"):
        changed = changed[:end] + changed[end + len(rest) :]
    return changed
