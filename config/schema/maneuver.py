"""Maneuver files: what the arm is asked to do. A maneuver is a name, a kind and that kind's parameters.

Positions are joint positions in the convention of the log: rotary 0 at mid stroke, positive anticlockwise; prismatic the
extension L. The straight line runs along X at constant y0, x positive to the right.

A joint quantity (`by`, `amplitude`, `speed`, ...) is in rad for a rotary and in m for a linear joint. Written with a unit it
is kept with it ("0.349 rad"), so that "20 deg" asked of a linear joint is refused when the run is planned.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, Tag, TypeAdapter, model_validator
from pydantic_core import PydanticCustomError

from config.errors import UnitError
from config.schema.section import Section, chosen_by, quantity
from config.units import to_si


def _joint_quantity(*units: str) -> BeforeValidator:
    """A number (SI unit of the joint) or a text that is a quantity in one of `units`; the text is kept as '<SI number> <unit>'."""

    def convert(value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise PydanticCustomError("unit", "a number with an optional unit was expected")
        with suppress(ValueError):
            return to_si(float(value), "")
        for unit in units:
            with suppress(UnitError):
                return f"{to_si(value, unit)!r} {unit}"
        raise PydanticCustomError("unit", "{text}", {"text": f"not a quantity in {' or '.join(units)}"})

    return BeforeValidator(convert)


JointPosition = Annotated[float | str, _joint_quantity("rad", "m")]
JointSpeed = Annotated[float | str, _joint_quantity("rad/s", "m/s")]
JointAcceleration = Annotated[float | str, _joint_quantity("rad/s^2", "m/s^2")]
Amplitude = Annotated[float | str, _joint_quantity("rad", "m", "V")]
AmplitudeRate = Annotated[float | str, _joint_quantity("rad/s", "m/s", "V/s")]
On = Literal["reference", "command"]


class Maneuver(Section):
    """What every maneuver has."""

    longreach: Literal["maneuver/1"] = Field(description="kind and version of this file")
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")] = Field(description="name in logs: small letters, digits, underscores")
    description: str = Field("", description="one line for the operator")


class StraightLine(Maneuver):
    """Moves along a straight line, exact in speed and acceleration, with a hold after each."""

    kind: Literal["straight_line"] = Field(description="what the arm does")
    y0_m: float = quantity("m", "distance of the line from the hub axis", low=0.05, high=10)
    x_start_m: float = quantity("m", "x of the first point", 0.0, low=-10, high=10)
    moves_m: tuple[float, ...] = quantity("m", "signed moves along x, one after the other")
    hold_s: float = quantity("s", "hold after every move", 2.0, low=0, high=600)
    speed_m_per_s: float = quantity("m/s", "largest speed along the line", low=1e-4, high=10)
    acceleration_m_per_s2: float = quantity("m/s^2", "largest acceleration along the line", low=1e-3, high=100)

    @model_validator(mode="after")
    def _has_moves(self) -> StraightLine:
        if not self.moves_m or 0.0 in self.moves_m:
            raise ValueError(f"moves must be one or more distances that are not 0, got {list(self.moves_m)}")
        return self


class JointManeuver(Maneuver):
    """What the maneuvers in joint space have: they start at `start`, or where the arm is when `start` says nothing of a joint."""

    start: dict[str, JointPosition] = Field(default_factory=dict, description="joint: position; other joints start where they are")


class JointStep(Section):
    """One move of one joint, to a position or by a distance, and a hold."""

    joint: str = Field(description="joint that moves")
    to: JointPosition | None = Field(None, description="position to move to, rad or m")
    by: JointPosition | None = Field(None, description="distance to move by, rad or m")
    hold_s: float = quantity("s", "hold after the move", 1.0, low=0, high=3600)
    speed: JointSpeed | None = Field(None, description="largest rate, rad/s or m/s; the joint's limit by default")
    acceleration: JointAcceleration | None = Field(None, description="largest acceleration, rad/s^2 or m/s^2; the joint's limit by default")

    @model_validator(mode="after")
    def _one_goal(self) -> JointStep:
        if (self.to is None) == (self.by is None):
            raise ValueError("a step needs either `to` or `by`")
        return self


class JointSteps(JointManeuver):
    """Moves of single joints, one after the other, each as fast as its speed and acceleration allow."""

    kind: Literal["joint_steps"] = Field(description="what the arm does")
    steps: tuple[JointStep, ...] = Field(min_length=1, description="moves, one after the other")


class Hold(JointManeuver):
    """Nothing moves for a while: noise floor, leak-down, drift."""

    kind: Literal["hold"] = Field(description="what the arm does")
    duration_s: float = quantity("s", "how long", low=0.01, high=36000)


class Jog(JointManeuver):
    """One slow move of one joint by a distance."""

    kind: Literal["jog"] = Field(description="what the arm does")
    joint: str = Field(description="joint that moves")
    by: JointPosition = Field(description="distance, rad or m")
    speed: JointSpeed | None = Field(None, description="largest rate; a fifth of the joint's limit by default")


class Excitation(JointManeuver):
    """A signal added to the held reference of one joint (`on: reference`, rad or m) or to its command (`on: command`, V)."""

    joint: str = Field(description="joint that is excited")
    on: On = Field("reference", description="what the signal is added to")


class SineSweep(Excitation):
    """A sine of constant amplitude with rising (or falling) frequency, faded in and out."""

    kind: Literal["sine_sweep"] = Field(description="what the arm does")
    amplitude: Amplitude = Field(description="peak, rad, m or V")
    from_Hz: float = quantity("Hz", "first frequency", low=1e-3, high=200)
    to_Hz: float = quantity("Hz", "last frequency", low=1e-3, high=200)
    duration_s: float = quantity("s", "length including the fades", low=0.1, high=3600)
    fade_s: float = quantity("s", "smooth fade in at the start and out at the end", 1.0, low=0, high=60)
    law: Literal["logarithmic", "linear"] = Field("logarithmic", description="how frequency grows with time")

    @model_validator(mode="after")
    def _fades_fit(self) -> SineSweep:
        if 2.0 * self.fade_s > self.duration_s:
            raise ValueError(f"two fades of {self.fade_s} s do not fit into a duration of {self.duration_s} s")
        return self


class Multisine(Excitation):
    """Periodic sum of odd harmonics with random phases: odd and even nonlinearity show up at the lines left out."""

    kind: Literal["multisine"] = Field(description="what the arm does")
    amplitude: Amplitude = Field(description="peak of the sum, rad, m or V")
    from_Hz: float = quantity("Hz", "lowest line", low=1e-3, high=200)
    to_Hz: float = quantity("Hz", "highest line", low=1e-3, high=200)
    period_s: float = quantity("s", "period; lines are odd multiples of its inverse", 10.0, low=0.1, high=100)
    periods: int = Field(2, ge=1, le=1000, description="full periods between the fades")
    lines: int = Field(30, ge=1, le=200, description="largest number of lines, spread evenly over log frequency")
    fade_s: float = quantity("s", "smooth fade before the first and after the last full period", 1.0, low=0, high=60)
    seed: int = Field(1, ge=0, description="seed of the phases")
    crest_limit: float = Field(2.5, ge=1.5, le=10, description="largest peak / rms; phases are drawn until it is met")


class SlowTriangle(Excitation):
    """Constant slow rate up, down and back: friction, backlash, valve null."""

    kind: Literal["slow_triangle"] = Field(description="what the arm does")
    amplitude: Amplitude = Field(description="peak either side of the start, rad, m or V")
    rate: AmplitudeRate = Field(description="slope, per second")
    cycles: int = Field(2, ge=1, le=1000, description="number of triangles")


class Staircase(Excitation):
    """Equal steps up, then down to the start again, with a hold on each."""

    kind: Literal["staircase"] = Field(description="what the arm does")
    step: Amplitude = Field(description="height of one step, rad, m or V; negative goes down first")
    steps: int = Field(5, ge=1, le=1000, description="steps each way")
    hold_s: float = quantity("s", "hold on every step", 1.0, low=0.01, high=3600)


class FastStrokes(JointManeuver):
    """Strokes back and forth as fast as allowed: supply droop, saturation, flow asymmetry."""

    kind: Literal["fast_strokes"] = Field(description="what the arm does")
    joint: str = Field(description="joint that moves")
    by: JointPosition = Field(description="stroke, rad or m")
    strokes: int = Field(4, ge=1, le=1000, description="number of strokes; an even number ends at the start")
    hold_s: float = quantity("s", "hold after every stroke", 1.0, low=0, high=3600)
    speed: JointSpeed | None = Field(None, description="largest rate; the joint's limit by default")
    acceleration: JointAcceleration | None = Field(None, description="largest acceleration; the joint's limit by default")


AnyManeuver = Annotated[
    Annotated[StraightLine, Tag("straight_line")]
    | Annotated[JointSteps, Tag("joint_steps")]
    | Annotated[SineSweep, Tag("sine_sweep")]
    | Annotated[Multisine, Tag("multisine")]
    | Annotated[SlowTriangle, Tag("slow_triangle")]
    | Annotated[Staircase, Tag("staircase")]
    | Annotated[FastStrokes, Tag("fast_strokes")]
    | Annotated[Hold, Tag("hold")]
    | Annotated[Jog, Tag("jog")],
    chosen_by("kind"),
]

_ANY: TypeAdapter[AnyManeuver] = TypeAdapter(AnyManeuver)


def maneuver_content(maneuver: Maneuver) -> dict[str, Any]:
    """The maneuver as a JSON-able dictionary with the keys of the file and values in SI (goes into a RunRequest)."""
    content: dict[str, Any] = maneuver.model_dump(mode="json", by_alias=True, exclude_none=True)
    return content


def maneuver_from_content(content: dict[str, Any]) -> AnyManeuver:
    """The inverse of maneuver_content. Raises pydantic.ValidationError; files are read with config.loading.load, which names lines."""
    return _ANY.validate_python(content)
