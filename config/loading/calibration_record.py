"""Calibration records: what `longreach identify` found about one rig, when, by whom, how sure, for how long. Rig files refer to them.

longreach: calibration/1
rig: ornl_testbed
identified_on: 2026-11-21
valid_until: 2027-05-20
by: operator@bench
software: longreach 0.1.0
source: simulated
logs: {ornl_testbed-1.mcap: 5f0c...}          # file name: SHA-256
link:
  payload: 20.41 kg
  ...
"""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Literal, cast

from pydantic import Field

from config.errors import ConfigError
from config.parsing.problems import config_error
from config.parsing.validation import validated
from config.parsing.yaml_tree import parse
from config.schema.rig import FrequencyPoint
from config.schema.section import Section, quantity


class LinkCalibration(Section):
    """The flexible link with the payload that was mounted. Uncertainties are two standard deviations."""

    payload_kg: float = quantity("kg", "mass at the tip", low=0, high=1000)
    payload_uncertainty_kg: float = quantity("kg", "without that of the bending stiffness", low=0, high=1000)
    damping_ratio: float | None = quantity("", "of the clamped link's first mode, mean over the holds", None, low=0, high=0.5)
    damping_uncertainty: float | None = quantity("", "of that mean", None, low=0, high=0.5)
    frequency_map: tuple[FrequencyPoint, ...] = Field(
        default=(), description="frequency as it rings in a hold, with the joint that gives, over the extension"
    )


class JointCalibration(Section):
    """One fit of gain / (s (s² + damping s + stiffness)) from command to position, of a single axis behind its valve's second-order lag;
    plain numbers in rad or m, V and s."""

    joint: str
    amplitude: float = Field(description="of the excitation as the maneuver has it, V on the command")
    extension_m: float | None = quantity("m", "mean over the run", None, low=0, high=100)
    oil_temperature_C: float | None = quantity("degC", "mean over the run", None, low=-40, high=150)
    position: float | None = Field(default=None, description="of a single axis, mean over the run")
    gain: float
    damping: float
    stiffness: float
    valve_frequency_Hz: float | None = quantity("Hz", "of a single axis: its valve, delays of the buses in it", None, low=0, high=1e5)
    valve_damping: float | None = Field(default=None, description="of a single axis: damping ratio of the valve")
    uncertainty: dict[str, float] = Field(default_factory=dict, description="relative, by name of the number")
    worst_dB: float = Field(description="largest error of the fit, magnitude")
    worst_deg: float = Field(description="largest error of the fit, phase")


class CalibrationRecord(Section):
    """One record."""

    longreach: Literal["calibration/1"] = Field(description="kind and version of this file")
    rig: str = Field(description="name of the rig it was made on")
    identified_on: datetime.date
    valid_until: datetime.date
    by: str = Field(description="who, and on which computer")
    software: str = Field(description="version that found the numbers")
    source: Literal["simulated", "rig", "logs"] = Field(description="where the logs came from")
    logs: dict[str, str] = Field(min_length=1, description="log: SHA-256 of its content")
    link: LinkCalibration | None = None
    joints: tuple[JointCalibration, ...] = ()


def load_record(path: Path) -> CalibrationRecord:
    """Read a record. ConfigError with file, line and column of every problem."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError("the calibration record cannot be read", value=error.strerror or str(error), where=str(path)) from error
    tree = parse(text, str(path))
    record, problems = validated(CalibrationRecord, tree)
    if problems or tree.problems:
        raise config_error(tree.name, [*tree.problems, *problems])
    return cast(CalibrationRecord, record)
