"""The `end_point:` section: feedback of the reflected tip, which damps the flexible link through the rotary joint. Absent: none."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, ValidationInfo, field_validator

from config.schema.section import Section, against, quantity, yaml_key


class EndPoint(Section):
    """Reflected-tip feedback (Wang and Vidyasagar): the rotary error gets gain · low-passed deflection / extension added."""

    source: Literal["deflection", "acceleration"] = Field(
        default="deflection", description="tip.deflection as measured, or estimated from tip.acceleration"
    )
    gain: float = quantity("", "share of the tip angle that is reflected; 1 is the whole", 0.5, low=0, high=2)
    roll_off_Hz: float = quantity(
        "Hz", "corner of the low-pass on the deflection; the second bending mode must lie well above", 15.0, low=1, high=200
    )
    full_below_Hz: float = quantity("Hz", "full gain while the link's frequency is below this", 6.0, low=0.1, high=500)
    off_above_Hz: float = quantity("Hz", "no feedback while the link's frequency is above this, a ramp in between", 9.0, low=0.1, high=500)
    lead_s: float = quantity(
        "s",
        "lag of joint and low-pass at the link's frequency that is taken out of the deflection, up to a quarter of a period (0: none)",
        0.0,
        low=0,
        high=0.05,
    )
    lead_from_Hz: float = quantity("Hz", "no lead while the link's frequency is below this", 5.5, low=0.1, high=500)
    lead_full_Hz: float = quantity("Hz", "the whole lead above this frequency of the link, a ramp in between", 8.0, low=0.1, high=500)
    limit_rad: float = quantity("rad", "largest tip angle that is used", 0.0523599, low=1e-4, high=0.5)
    fade_s: float = quantity("s", "the feedback comes in over this time", 0.5, low=0.01, high=10)
    loss_fade_s: float = quantity("s", "the feedback goes out over this time when the signal is lost", 0.05, low=0.001, high=10)
    friction_gain: float = quantity(
        "s/rad",
        "share of the friction in servo.rotary.oil_compensation that is overcome while the reference rests, per angle of the correction "
        "and angular frequency of the link; up to its feedback_share",
        0.0,
        low=0,
        high=1000,
    )
    friction_high_pass_Hz: float = quantity(
        "Hz",
        "corner of a high-pass between the correction and friction_gain, so that a deflection sensor that is off does not use the share "
        "up; well below the slowest link (0: none)",
        0.0,
        low=0,
        high=5,
    )
    acceleration_noise_m_per_s2: float = quantity("m/s^2", "of tip.acceleration, for the estimator", 0.02, low=1e-4, high=10)

    @field_validator("off_above_Hz", "lead_full_Hz")
    @classmethod
    def _ramp_upwards(cls, end: float, info: ValidationInfo) -> float:
        begin_key = {"off_above_Hz": "full_below_Hz", "lead_full_Hz": "lead_from_Hz"}[info.field_name or ""]
        begin = info.data.get(begin_key)
        if begin is not None and end <= begin:
            key = yaml_key(begin_key)
            raise against(f"must be above {key}", key, f"{begin:g} Hz")
        return end
