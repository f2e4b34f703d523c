"""The `signals:` section: where each signal comes from, how raw counts become engineering values, when a value is believed.

A signal's name says what it measures, and so its unit: `rotary.position` is in rad, `rotary.supply_pressure` in Pa,
`reservoir_temperature` in degC. The loader puts that into `measures`, which chooses the class.
"""

from __future__ import annotations

import datetime
from typing import Annotated, Any, Literal

from pydantic import Field, Tag, ValidationInfo, field_validator

from config.schema.section import Section, against, chosen_by, inferred, quantity, unit_of
from config.signal_names import signal_measures


class Calibration(Section):
    """engineering value = offset + scale × raw count."""

    scale: float
    offset: float
    calibrated_on: datetime.date | None = Field(default=None, description="day of the calibration, YYYY-MM-DD")
    valid_until: datetime.date | None = Field(default=None, description="day after which the calibration must be repeated, YYYY-MM-DD")
    by: str = Field(default="", description="who calibrated, and how")
    uncertainty: float | None
    on_expiry: Literal["warn", "block"] = Field(default="warn", description="what an expired calibration does at arming")

    @field_validator("valid_until")
    @classmethod
    def _after_its_day(cls, until: datetime.date | None, info: ValidationInfo) -> datetime.date | None:
        begun = info.data.get("calibrated_on")
        if until is not None and begun is not None and until < begun:
            raise ValueError(f"valid_until must not be before calibrated_on ({begun})")
        return until


class Signal(Section):
    """What every signal has; the subclasses give the unit of calibration, low and high."""

    device: str = Field(description="name of a device of this file")
    channel: str = Field(description="the device's name of the channel")
    calibration: Calibration
    low: float | None
    high: float | None
    max_age_s: float = quantity("s", "older samples are stale", 0.005, low=1e-4, high=60)
    required: bool = Field(default=True, description="a bad or stale value of a required signal is a fault while armed")

    @field_validator("high")
    @classmethod
    def _range_ordered(cls, high: float | None, info: ValidationInfo) -> float | None:
        low = info.data.get("low")
        if high is not None and low is not None and low >= high:
            raise against("high must be above low", "low", f"{low:g} {unit_of(cls.model_fields['high'])}")
        return high


class AngleCalibration(Calibration):
    scale: float = quantity("rad", "engineering value per raw count", 1.0)
    offset: float = quantity("rad", "engineering value at raw count 0", 0.0)
    uncertainty: float | None = quantity("rad", "expanded uncertainty (k = 2) of the engineering value", None, low=0)


class AngleSignal(Signal):
    measures: Literal["angle"] = inferred("from the signal's name")
    calibration: AngleCalibration = Field(default=AngleCalibration(), description="engineering value = offset + scale × raw count")
    low: float | None = quantity("rad", "smallest plausible value", None)
    high: float | None = quantity("rad", "largest plausible value", None)


class LengthCalibration(Calibration):
    scale: float = quantity("m", "engineering value per raw count", 1.0)
    offset: float = quantity("m", "engineering value at raw count 0", 0.0)
    uncertainty: float | None = quantity("m", "expanded uncertainty (k = 2) of the engineering value", None, low=0)


class LengthSignal(Signal):
    measures: Literal["length"] = inferred("from the signal's name")
    calibration: LengthCalibration = Field(default=LengthCalibration(), description="engineering value = offset + scale × raw count")
    low: float | None = quantity("m", "smallest plausible value", None)
    high: float | None = quantity("m", "largest plausible value", None)


class PressureCalibration(Calibration):
    scale: float = quantity("Pa", "engineering value per raw count", 1.0)
    offset: float = quantity("Pa", "engineering value at raw count 0", 0.0)
    uncertainty: float | None = quantity("Pa", "expanded uncertainty (k = 2) of the engineering value", None, low=0)


class PressureSignal(Signal):
    measures: Literal["pressure"] = inferred("from the signal's name")
    calibration: PressureCalibration = Field(default=PressureCalibration(), description="engineering value = offset + scale × raw count")
    low: float | None = quantity("Pa", "smallest plausible value, gauge", None)
    high: float | None = quantity("Pa", "largest plausible value, gauge", None)


class TemperatureCalibration(Calibration):
    scale: float = quantity("K", "engineering value per raw count", 1.0)
    offset: float = quantity("degC", "engineering value at raw count 0", 0.0)
    uncertainty: float | None = quantity("K", "expanded uncertainty (k = 2) of the engineering value", None, low=0)


class TemperatureSignal(Signal):
    measures: Literal["temperature"] = inferred("from the signal's name")
    calibration: TemperatureCalibration = Field(
        default=TemperatureCalibration(), description="engineering value = offset + scale × raw count"
    )
    low: float | None = quantity("degC", "smallest plausible value", None)
    high: float | None = quantity("degC", "largest plausible value", None)


class AccelerationCalibration(Calibration):
    scale: float = quantity("m/s^2", "engineering value per raw count", 1.0)
    offset: float = quantity("m/s^2", "engineering value at raw count 0", 0.0)
    uncertainty: float | None = quantity("m/s^2", "expanded uncertainty (k = 2) of the engineering value", None, low=0)


class AccelerationSignal(Signal):
    measures: Literal["acceleration"] = inferred("from the signal's name")
    calibration: AccelerationCalibration = Field(
        default=AccelerationCalibration(), description="engineering value = offset + scale × raw count"
    )
    low: float | None = quantity("m/s^2", "smallest plausible value", None)
    high: float | None = quantity("m/s^2", "largest plausible value", None)


AnySignal = Annotated[
    Annotated[AngleSignal, Tag("angle")]
    | Annotated[LengthSignal, Tag("length")]
    | Annotated[PressureSignal, Tag("pressure")]
    | Annotated[TemperatureSignal, Tag("temperature")]
    | Annotated[AccelerationSignal, Tag("acceleration")],
    chosen_by("measures"),
]


def with_inferred(rig: Any) -> Any:
    """The plain content of a rig file with `measures` of every signal and `motion` of every servo filled in where it is known."""
    if not isinstance(rig, dict):
        return rig
    motions = {name: joint["motion"] for name, joint in _sections(rig, "joints") if isinstance(joint.get("motion"), str)}
    measures = signal_measures(motions)
    filled = dict(rig)
    for section, key, values in (("servo", "motion", motions), ("signals", "measures", measures)):
        if isinstance(rig.get(section), dict):
            known = {name: {key: values[name], **entry} for name, entry in _sections(rig, section) if name in values}
            filled[section] = {**rig[section], **known}
    return filled


def _sections(rig: dict[str, Any], key: str) -> list[tuple[str, dict[str, Any]]]:
    entries = rig.get(key)
    pairs = entries.items() if isinstance(entries, dict) else ()
    return [(name, entry) for name, entry in pairs if isinstance(entry, dict)]
