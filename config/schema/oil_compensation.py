"""The `oil_compensation:` section of a servo: the feed-forward follows the measured oil temperature. Absent: one constant for all."""

from __future__ import annotations

from itertools import pairwise

from pydantic import Field, field_validator

from config.schema.section import Section, quantity


class OilPoint(Section):
    """What the joint needs at one oil temperature: u = velocity_feedforward · velocity_factor · rate + friction · sign(rate) + bias.

    A cylinder whose areas differ takes more volts a rate in than out: `velocity_factor_back` is its factor towards smaller positions.
    """

    temperature_C: float = quantity("degC", "oil temperature of this point", low=-40, high=120)
    velocity_factor: float = Field(default=1.0, ge=0.1, le=10.0, description="times velocity_feedforward")
    velocity_factor_back: float | None = Field(
        default=None, ge=0.1, le=10.0, description="the same towards smaller positions (areas of a cylinder differ); default: as forth"
    )
    friction_V: float = quantity("V", "added in the direction of motion: flow that leaks while friction is overcome", 0.0, low=-2, high=2)
    bias_V: float = quantity("V", "added in both directions: the valve's null, which moves with temperature", 0.0, low=-2, high=2)


class OilCompensation(Section):
    """Table over temperature, straight lines between its points, constant beyond them."""

    source: str = Field(description="the temperature signal, e.g. rotary.return_temperature: the one nearest to the actuator's oil")
    filter_s: float = quantity("s", "time constant of the low-pass on the temperature", 10.0, low=0.1, high=600)
    feedback_share: float = quantity(
        "", "share of the friction that a feedback may have overcome; what is left must hold a joint at rest", 0.6, low=0, high=0.9
    )
    points: tuple[OilPoint, ...] = Field(min_length=1, max_length=50, description="in the order of rising temperature")

    @field_validator("points")
    @classmethod
    def _rising(cls, points: tuple[OilPoint, ...]) -> tuple[OilPoint, ...]:
        temperatures = [point.temperature_C for point in points]
        if any(later <= earlier for earlier, later in pairwise(temperatures)):
            raise ValueError(f"temperatures must rise from point to point, got {temperatures} degC")
        return points


class RotaryOilCompensation(OilCompensation):
    friction_rate: float = quantity(
        "rad/s", "reference rate from which the full friction is added; proportional below", 0.0175, low=1e-5, high=10
    )


class LinearOilCompensation(OilCompensation):
    friction_rate: float = quantity(
        "m/s", "reference rate from which the full friction is added; proportional below", 0.005, low=1e-6, high=5
    )
