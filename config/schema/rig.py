"""The rig file: everything the daemon needs to know about one rig. One class a section, in the order of the file."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Tag, ValidationInfo, field_validator, model_validator

from config.schema.end_point import EndPoint
from config.schema.plant import Plant
from config.schema.plausibility import Plausibility
from config.schema.section import Section, against, chosen_by, quantity, unit_of, yaml_key
from config.schema.servo import AnyServo
from config.schema.signals import AnySignal, with_inferred

RIG_NAME = r"^[a-z][a-z0-9_-]{0,63}$"
JointName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,63}$")]
DeviceName = Annotated[str, Field(pattern=r"^[^/\s]{1,64}$")]  # stands in names of files


class Overruns(Section):
    """What the loop does when it is late (docs: overrun policy)."""

    window_s: float = quantity("s", "length of the window in which overruns are counted", 1.0, low=0.01, high=60)
    stop_after: int = Field(default=20, ge=1, description="overruns in one window that cause a controlled stop")
    fault_late_s: float = quantity("s", "one cycle later than this is a fault", 0.05, low=0.001, high=1)


class Loop(Section):
    """The fixed-rate loop."""

    rate_Hz: float = quantity("Hz", "cycles per second", 1000.0, low=10, high=2000)
    demand_rate: bool = Field(default=False, description="arming demands that `longreach host` has seen this computer keep `rate`")
    spin_s: float = quantity("s", "least spin before a deadline; longer where wake-ups are later; 0: none", 150e-6, low=0, high=1e-3)
    priority: int = Field(default=80, ge=0, le=98, description="SCHED_FIFO priority asked for; 0 asks for none")
    cpu: int | None = Field(default=None, ge=0, description="processor the control process is pinned to; none by default")
    countdown_s: float = quantity("s", "announcement before motion starts", 3.0, low=0, high=30)
    set_point_timeout_s: float = quantity(
        "s",
        "driving by hand ends in a controlled stop when no set point has come for this long; with the ways to the loop and in it 0.15 s",
        0.14,
        low=0.02,
        high=0.5,
    )
    overruns: Overruns = Overruns()


class Joint(Section):
    """Limits of one joint; `position_unit` is rad for rotary and m for linear joints, set by the subclasses."""

    position_unit: ClassVar[str]
    travel: tuple[float, float]
    rate_limit: float
    acceleration_limit: float
    following_error_limit: float
    command_limit_V: float = quantity("V", "largest command to the valve, either sign", 10.0, low=0.01, high=15)
    command_rate_limit_V_per_s: float = quantity("V/s", "fastest change of the command", 5000.0, low=1, high=1e5)

    @field_validator("travel")
    @classmethod
    def _travel_ordered(cls, travel: tuple[float, float]) -> tuple[float, float]:
        if travel[0] >= travel[1]:
            raise ValueError("travel must be [lower, upper] with lower < upper")
        return travel


class RotaryJoint(Joint):
    position_unit: ClassVar[str] = "rad"
    motion: Literal["rotary"] = Field(description="how the joint moves")
    travel: tuple[float, float] = quantity("rad", "allowed positions, lower and upper")
    rate_limit: float = quantity("rad/s", "largest reference rate", low=1e-4, high=20)
    acceleration_limit: float = quantity("rad/s^2", "largest reference acceleration", low=1e-3, high=500)
    following_error_limit: float = quantity("rad", "largest |reference - position| before the arm is stopped", low=1e-4, high=3)


class LinearJoint(Joint):
    position_unit: ClassVar[str] = "m"
    motion: Literal["linear"] = Field(description="how the joint moves")
    travel: tuple[float, float] = quantity("m", "allowed positions, lower and upper")
    rate_limit: float = quantity("m/s", "largest reference rate", low=1e-5, high=10)
    acceleration_limit: float = quantity("m/s^2", "largest reference acceleration", low=1e-4, high=200)
    following_error_limit: float = quantity("m", "largest |reference - position| before the arm is stopped", low=1e-6, high=1)


AnyJoint = Annotated[Annotated[RotaryJoint, Tag("rotary")] | Annotated[LinearJoint, Tag("linear")], chosen_by("motion")]


class Arm(Section):
    """How the joints make an arm. `rotary_prismatic` needs the joints rotary and prismatic; `single_axis` has one joint."""

    kind: Literal["rotary_prismatic", "single_axis"] = Field(description="geometry of the arm")
    hub_offset_m: float = quantity("m", "hub axis to bearing exit", 0.0, low=0, high=2)


class FrequencyPoint(Section):
    """A measured frequency of the link."""

    extension_m: float = quantity("m", "where it was measured", low=1e-3, high=100)
    frequency_Hz: float = quantity("Hz", "damped frequency with the payload of link_mode", low=0.01, high=1000)
    uncertainty_Hz: float = quantity("Hz", "two standard deviations", 0.0, low=0, high=1000)


class LinkMode(Section):
    """What the controller believes about the flexible link: gives the frequency the shapers use."""

    bending_stiffness_N_m2: float = quantity("N*m^2", "EI of the link", low=1e-3, high=1e7)
    mass_per_length_kg_per_m: float = quantity("kg/m", "rho A of the link", low=0.01, high=200)
    payload_kg: float = quantity("kg", "mass at the tip", low=0, high=1000)
    damping_ratio: float = quantity("", "structural damping ratio of the first mode", 0.005, low=0, high=0.5)
    frequency_map: tuple[FrequencyPoint, ...] = Field(
        default=(), max_length=100, description="measured frequencies that correct the formula, in the order of rising extension"
    )

    @field_validator("frequency_map")
    @classmethod
    def _map_rises(cls, points: tuple[FrequencyPoint, ...]) -> tuple[FrequencyPoint, ...]:
        extensions = [point.extension_m for point in points]
        if any(later <= earlier for earlier, later in pairwise(extensions)):
            raise ValueError(f"extensions must rise from point to point, got {extensions} m")
        return points


class Identified(Section):
    """Numbers of link_mode that come from a calibration record; what stands in link_mode itself is replaced when the file is loaded."""

    record: str = Field(description="calibration record (`longreach identify`); a relative path counts from the rig file")
    use: tuple[Literal["payload", "frequency_map", "damping_ratio"], ...] | None = Field(
        default=None, min_length=1, description="what is taken from it; without it, all that the record has"
    )


class Output(Section):
    """Where a joint's command goes."""

    device: str = Field(description="name of a device of this file")
    channel: str = Field(description="the device's name of the channel")
    scale: float = quantity("", "device units per volt, not 0; negative turns the direction round", 1.0)

    @field_validator("scale")
    @classmethod
    def _reaches_the_device(cls, scale: float) -> float:
        if scale == 0.0:
            raise ValueError("the device gets 0 whatever is commanded; give what it takes for 1 V")
        return scale


class Device(Section):
    """One device and the driver (entry-point group longreach.drivers) that speaks to it."""

    driver: str = Field(description="name of an installed driver")
    slow: bool = Field(default=False, description="true: served by the I/O process, never inside the loop")
    timeout_s: float = quantity("s", "the device makes its outputs safe when not written for this long", 0.1, low=0.002, high=5)
    demand_proof: bool | None = Field(
        default=None,
        description="arming demands that the device's safe state was proven since the daemon started (`longreach prove`); by default of"
        " CANopen valves and output modules; true demands it of any other driver too, which must be able to prove it",
    )
    options: dict[str, Any] = Field(default_factory=dict, description="driver's own options")


class Interlocks(Section):
    """Limits that must hold to arm and while armed. An absent limit is not checked."""

    supply_pressure_min_Pa: float | None = quantity("Pa", "supply pressure at every valve", None, low=0, high=40e6)
    supply_pressure_max_Pa: float | None = quantity("Pa", "supply pressure at every valve", None, low=0, high=60e6)
    return_pressure_max_Pa: float | None = quantity("Pa", "return pressure at every valve", None, low=0, high=10e6)
    oil_temperature_min_C: float | None = quantity("degC", "reservoir temperature", None, low=-40, high=120)
    oil_temperature_max_C: float | None = quantity("degC", "reservoir temperature", None, low=-40, high=120)
    tip_acceleration_max_m_per_s2: float | None = quantity("m/s^2", "transverse tip acceleration", None, low=0, high=1000)
    start_swing_max_m_per_s2: float = quantity(
        "m/s^2", "most vibration of the tip (rms) from which a run starts that waits for rest (`start --settle`)", 0.1, low=1e-3, high=100
    )
    disk_free_min_bytes: float = quantity("bytes", "free space where logs are written", 200e6, low=0)
    proof_pressure_max_Pa: float = quantity(
        "Pa", "most supply pressure during the proof of the safe state, in which valves open", 0.3e6, low=0, high=5e6
    )
    plausibility: Plausibility = Plausibility()

    @field_validator("supply_pressure_max_Pa", "oil_temperature_max_C")
    @classmethod
    def _above_its_minimum(cls, largest: float | None, info: ValidationInfo) -> float | None:
        name = str(info.field_name)
        smallest = info.data.get(name.replace("_max_", "_min_"))
        if largest is not None and smallest is not None and smallest >= largest:
            stored = f"{smallest:g} {unit_of(cls.model_fields[name])}"
            raise against("the maximum must be above the minimum", yaml_key(name).replace("_max", "_min"), stored)
        return largest


class Rig(Section):
    """One rig."""

    longreach: Literal["rig/1"] = Field(description="kind and version of this file")
    name: Annotated[str, Field(pattern=RIG_NAME, description="short name; stands in logs")]
    description: str = Field(default="", description="one line about the rig")
    arm: Arm
    loop: Loop = Loop()
    joints: dict[JointName, AnyJoint] = Field(min_length=1, description="every joint by name, in the order of logs and outputs")
    servo: dict[JointName, AnyServo] = Field(description="the controller of every joint")
    link_mode: LinkMode | None = None
    identified: Identified | None = None
    end_point: EndPoint | None = None
    devices: dict[DeviceName, Device] = Field(min_length=1, description="every device by name")
    signals: dict[str, AnySignal] = Field(description="every fitted sensor; the name says what it measures, see below")
    outputs: dict[JointName, Output] = Field(description="where the command of every joint goes")
    interlocks: Interlocks = Interlocks()
    plant: Plant | None = Field(default=None, description="the simulated rig; the daemon does not use it on hardware")

    @model_validator(mode="before")
    @classmethod
    def _fill_in(cls, content: Any) -> Any:
        return with_inferred(content)
