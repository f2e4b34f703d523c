"""The `plant.joints` section: what drives each joint. `actuator` chooses: `rotary`, `cylinder`, `force`, `torque`, or for motion
that is imposed from outside `turntable` and `crosshead`."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Tag, ValidationInfo, field_validator

from config.schema.section import Section, against, chosen_by, quantity


class Valve(Section):
    """Servovalve: four lands with a rounded null. The spool follows its command within the slew rate (see effect valve_lag)."""

    rated_flow_m3_per_s: float = quantity("m^3/s", "flow at full opening and the rated pressure drop", low=1e-8, high=1)
    rated_pressure_drop_Pa: float = quantity("Pa", "over both lands together", 6894757.0, low=1e4, high=50e6)
    full_scale_V: float = quantity("V", "command for full opening", low=0.01, high=100)
    stroke_time_s: float = quantity("s", "from null to full opening at the fastest", 0.01, low=1e-4, high=1)
    null_rounding: float = quantity("", "width of the rounded null, share of the full opening", low=1e-4, high=0.2)
    null_adjustment: float = quantity(
        "", "opening at command 0 set by the valve's null adjuster, share of the full opening", 0.0, low=-0.2, high=0.2
    )
    laminar_pressure_Pa: float = quantity("Pa", "pressure drop below which a land's flow is laminar", 2e4, low=1e2, high=1e6)


class PlantJoint(Section):
    """What every joint has: start position, mechanical stops and what a seal does before it slides (LuGre bristles)."""

    motion: ClassVar[str]
    is_hydraulic: ClassVar[bool] = False
    is_imposed: ClassVar[bool] = False  # its measured motion goes into the simulation
    travel: tuple[float, float]
    initial: float
    stop_stiffness: float
    stop_restitution_loss: float
    bristle_stiffness: float
    bristle_damping: float
    bristle_fade: float

    @field_validator("travel", check_fields=False)
    @classmethod
    def _travel_ordered(cls, travel: tuple[float, float]) -> tuple[float, float]:
        if travel[0] >= travel[1]:
            raise ValueError("travel must be [lower, upper] with lower < upper")
        return travel

    @field_validator("initial", check_fields=False)
    @classmethod
    def _initial_inside(cls, initial: float, info: ValidationInfo) -> float:
        travel = info.data.get("travel")
        if travel and not travel[0] <= initial <= travel[1]:
            raise against("the start position must lie within the mechanical travel", "travel", str(list(travel)))
        return initial


class RotaryPlantJoint(PlantJoint):
    motion: ClassVar[str] = "rotary"
    travel: tuple[float, float] = quantity("rad", "mechanical stops, lower and upper")
    initial: float = quantity("rad", "position at the start", 0.0)
    stop_stiffness: float = quantity("N*m/rad", "of the mechanical stops", 2e6, low=1, high=1e10)
    stop_restitution_loss: float = quantity("s/rad", "Hunt-Crossley damping of the stops, relative to stiffness", 1.0, low=0, high=100)
    bristle_stiffness: float = quantity("N*m/rad", "friction's stiffness before sliding", 3e5, low=1, high=1e10)
    bristle_damping: float = quantity("N*m*s/rad", "friction's damping before sliding", 1185.0, low=0, high=1e8)
    bristle_fade: float = quantity("rad/s", "speed at which that damping has faded to 1/e", 0.02, low=1e-6, high=10)


class LinearPlantJoint(PlantJoint):
    motion: ClassVar[str] = "linear"
    travel: tuple[float, float] = quantity("m", "mechanical stops, lower and upper")
    initial: float = quantity("m", "position at the start", 0.0)
    stop_stiffness: float = quantity("N/m", "of the mechanical stops", 2e7, low=1, high=1e11)
    stop_restitution_loss: float = quantity("s/m", "Hunt-Crossley damping of the stops, relative to stiffness", 2.0, low=0, high=1000)
    bristle_stiffness: float = quantity("N/m", "friction's stiffness before sliding", 8e6, low=1, high=1e11)
    bristle_damping: float = quantity("N*s/m", "friction's damping before sliding", 1e4, low=0, high=1e9)
    bristle_fade: float = quantity("m/s", "speed at which that damping has faded to 1/e", 0.005, low=1e-6, high=10)


class RotaryActuator(RotaryPlantJoint):
    """A valve-controlled rotary actuator; the volumes are at rotary position 0."""

    is_hydraulic: ClassVar[bool] = True
    actuator: Literal["rotary"]
    displacement_m3_per_rad: float = quantity("m^3/rad", "oil per angle", low=1e-9, high=1)
    volume_a_m3: float = quantity("m^3", "chamber A with its line", low=1e-7, high=1)
    volume_b_m3: float = quantity("m^3", "chamber B with its line", low=1e-7, high=1)
    inertia_kg_m2: float = quantity("kg*m^2", "turning inertia; only for a single axis (an arm's is in link)", 0.0, low=0, high=1e7)
    valve: Valve


class Cylinder(LinearPlantJoint):
    """A valve-controlled cylinder; chamber A is the cap end and grows with extension."""

    is_hydraulic: ClassVar[bool] = True
    actuator: Literal["cylinder"]
    bore_m: float = quantity("m", "diameter of the piston", low=1e-3, high=2)
    rod_m: float = quantity("m", "diameter of the rod", low=0, high=2)
    dead_volume_a_m3: float = quantity("m^3", "cap end with its line, rod fully in", low=1e-7, high=1)
    dead_volume_b_m3: float = quantity("m^3", "rod end with its line, rod fully out", low=1e-7, high=1)
    mass_kg: float = quantity("kg", "moving mass; only for a single axis (an arm's is in link)", 0.0, low=0, high=1e6)
    valve: Valve

    @field_validator("rod_m")
    @classmethod
    def _rod_thinner(cls, rod: float, info: ValidationInfo) -> float:
        if rod >= info.data.get("bore_m", math.inf):
            raise ValueError("the rod must be thinner than the bore")
        return rod


class ForceActuator(LinearPlantJoint):
    """Force = gain × command on a mass, nothing hydraulic."""

    actuator: Literal["force"]
    gain_N_per_V: float = quantity("N/V", "force per command", low=-1e6, high=1e6)
    full_scale_V: float = quantity("V", "the drive saturates here", 10.0, low=0.01, high=1000)
    mass_kg: float = quantity("kg", "moving mass", low=1e-6, high=1e6)


class TorqueActuator(RotaryPlantJoint):
    """Torque = gain × command on an inertia, nothing hydraulic."""

    actuator: Literal["torque"]
    gain_N_m_per_V: float = quantity("N*m/V", "torque per command", low=-1e6, high=1e6)
    full_scale_V: float = quantity("V", "the drive saturates here", 10.0, low=0.01, high=1000)
    inertia_kg_m2: float = quantity("kg*m^2", "turning inertia", low=1e-9, high=1e7)


class Turntable(RotaryPlantJoint):
    """The joint turns as it was measured, whatever acts on it: for data in which only what hangs on the joint is in question."""

    is_imposed: ClassVar[bool] = True
    actuator: Literal["turntable"]


class Crosshead(LinearPlantJoint):
    """The joint slides as it was measured: a testing machine moves a rod, or the slide is clamped. With an area, the rod presses on a
    chamber whose pressure is measured, and the command is the load cell's force that pushes the rod into the chamber."""

    is_imposed: ClassVar[bool] = True
    actuator: Literal["crosshead"]
    area_m2: float = quantity("m^2", "of the rod in the chamber; 0: there is no chamber", 0.0, low=0, high=10)
    gain_N_per_V: float = quantity("N/V", "load cell's force per command", 1.0, low=-1e6, high=1e6)
    full_scale_V: float = quantity("V", "end of the load cell's range", 1000.0, low=0.01, high=1e6)
    mass_kg: float = quantity("kg", "of what the load cell moves", 0.0, low=0, high=1e6)


AnyPlantJoint = Annotated[
    Annotated[RotaryActuator, Tag("rotary")]
    | Annotated[Cylinder, Tag("cylinder")]
    | Annotated[ForceActuator, Tag("force")]
    | Annotated[TorqueActuator, Tag("torque")]
    | Annotated[Turntable, Tag("turntable")]
    | Annotated[Crosshead, Tag("crosshead")],
    chosen_by("actuator"),
]

_MOTIONS = {"rotary": "rotary", "torque": "rotary", "turntable": "rotary", "cylinder": "linear", "force": "linear", "crosshead": "linear"}


def motion_of(joint: dict[str, Any]) -> str:
    """Motion of a joint from the plain content of its section; empty when its actuator is unknown."""
    return _MOTIONS.get(str(joint.get("actuator")), "")
