"""The `plant.sensors` section: one entry a signal, in the signal's unit (rad, m, Pa, degC, m/s²)."""

from __future__ import annotations

from pydantic import ValidationInfo, field_validator

from config.schema.effect_entry import READING, PlacedSection, quantity_by_place
from config.schema.section import against, quantity

VALUE = {**READING, "temperature": "degC"}


class Sensor(PlacedSection):
    """A simulated transducer: first-order lag, bias, noise, range, resolution. Its raw count is the reading over the resolution."""

    resolution: float = quantity_by_place(READING, "one count", low=1e-12, high=1e6)
    noise: float = quantity_by_place(READING, "rms", 0.0, low=0, high=1e9)
    bandwidth_Hz: float = quantity("Hz", "corner of the first-order lag, which also colours the noise; 0 has no lag", 0.0, low=0, high=1e6)
    bias: float = quantity_by_place(READING, "constant error", 0.0, low=-1e9, high=1e9)
    low: float = quantity_by_place(VALUE, "lower end of the range, where the reading stops")
    high: float = quantity_by_place(VALUE, "upper end of the range, where the reading stops")
    dropout: float = quantity("", "probability that a sample is missing", 0.0, low=0, high=1)

    @field_validator("high")
    @classmethod
    def _range_ordered(cls, high: float, info: ValidationInfo) -> float:
        low, unit = info.data.get("low"), VALUE.get(info.data.get("quantity_kind", ""))
        if low is not None and unit and low >= high:  # without a unit the place is the mistake, and the numbers are stand-ins
            raise against("high must be above low", "low", f"{low:g} {unit}")
        return high
