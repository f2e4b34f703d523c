"""The `servo:` section: for every joint the gain, the lag-lead sections, feed-forward and how velocity is estimated."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, Tag, ValidationInfo, field_validator

from config.schema.oil_compensation import LinearOilCompensation, RotaryOilCompensation
from config.schema.section import Section, against, chosen_by, inferred, quantity


class LagLeadSection(Section):
    """One first-order section (1 + s/zero) / (1 + s/pole), DC gain 1: lead for zero < pole, lag for zero > pole."""

    zero_rad_per_s: float = quantity("rad/s", "corner of the zero", low=1e-3, high=1e4)
    pole_rad_per_s: float = quantity("rad/s", "corner of the pole", low=1e-3, high=1e4)


class GainPoint(Section):
    """What the gain is multiplied by at one extension of the link."""

    extension_m: float = quantity("m", "extension of this point", low=0, high=100)
    factor: float = Field(gt=0.0, le=20.0, description="times `gain`")


class LinkNotchRange(Section):
    """From which believed frequency of the link on its notch stands in the rotary error: there the encoder's noise would shake it."""

    none_below_Hz: float = quantity("Hz", "no notch while the link's frequency is below this", 16.0, low=0.1, high=500)
    full_above_Hz: float = quantity("Hz", "the whole notch above this frequency of the link, a ramp in between", 18.0, low=0.1, high=500)

    @field_validator("full_above_Hz")
    @classmethod
    def _ramp_upwards(cls, end: float, info: ValidationInfo) -> float:
        begin = info.data.get("none_below_Hz")
        if begin is not None and end <= begin:
            raise against("must be above none_below", "none_below", f"{begin:g} Hz")
        return end


class JointServo(Section):
    """What every joint servo has; the subclasses give the units of gain and feed-forward."""

    sections: tuple[LagLeadSection, ...] = Field(default=(), description="lag-lead sections, one after the other")
    velocity_filter_Hz: float = quantity("Hz", "corner of the filter in the velocity estimate", 50.0, low=0.1, high=1000)
    gain: float
    velocity_feedforward: float
    null_bias_V: float = quantity("V", "constant added to the command, opposite to the valve's null bias", 0.0, low=-2, high=2)
    acceleration_feedforward: float
    dither_V: float = quantity(
        "V", "added with the other sign in every cycle; more than half the valve's hysteresis frees the spool of it", 0.0, low=0, high=1
    )


class RotaryServo(JointServo):
    motion: Literal["rotary"] = inferred("from the joint of the same name")
    gain: float = quantity("V/rad", "proportional gain, DC gain of the whole compensator", low=-2000, high=2000)
    velocity_feedforward: float = quantity("V*s/rad", "volts per rate of the reference", 0.0, low=-200, high=200)
    acceleration_feedforward: float = quantity("V*s^2/rad", "volts per acceleration of the reference", 0.0, low=-20, high=20)
    oil_compensation: RotaryOilCompensation | None = None
    gain_schedule: tuple[GainPoint, ...] = Field(
        default=(), max_length=50, description="by rising extension, straight lines between the points, constant beyond; none: one gain"
    )
    link_notch: LinkNotchRange | None = None

    @field_validator("gain_schedule")
    @classmethod
    def _rising(cls, points: tuple[GainPoint, ...]) -> tuple[GainPoint, ...]:
        extensions = [point.extension_m for point in points]
        if any(later <= earlier for earlier, later in pairwise(extensions)):
            raise ValueError(f"extensions must rise from point to point, got {extensions} m")
        return points


class LinearServo(JointServo):
    motion: Literal["linear"] = inferred("from the joint of the same name")
    gain: float = quantity("V/m", "proportional gain, DC gain of the whole compensator", low=-1e6, high=1e6)
    velocity_feedforward: float = quantity("V*s/m", "volts per rate of the reference", 0.0, low=-2000, high=2000)
    acceleration_feedforward: float = quantity("V*s^2/m", "volts per acceleration of the reference", 0.0, low=-200, high=200)
    oil_compensation: LinearOilCompensation | None = None


AnyServo = Annotated[Annotated[RotaryServo, Tag("rotary")] | Annotated[LinearServo, Tag("linear")], chosen_by("motion")]
