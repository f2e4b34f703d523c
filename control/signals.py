"""What goes into and comes out of `Controller.step`: plain values only, so that a log re-executes bit for bit (design.md §2)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Mode(IntEnum):
    """Modes of the daemon; the number is what the log stores."""

    DISARMED = 0
    ARMING = 1
    HOLDING = 2
    RUNNING = 3
    STOPPING = 4
    FAULT = 5
    PROVING = 6


@dataclass(slots=True)
class Inputs:
    """One cycle's inputs. `position` is in the order of `rig.joints`; NaN where a sensor is not fitted or failed."""

    cycle: int
    mode: int
    run: int  # number of the prepared run; 0 when there is none
    position: tuple[float, ...]
    tip_deflection_m: float
    tip_acceleration_mps2: float
    oil_temperature_C: tuple[float, ...] = ()  # of every joint's oil compensation, in the order of the joints; empty when none has one


@dataclass(slots=True)
class JointOutput:
    """One joint's servo quantities (rad or m, V), as in the log contract."""

    target: float
    target_rate: float
    reference: float
    reference_rate: float
    velocity: float
    command_V: float


@dataclass(slots=True)
class Outputs:
    """One cycle's result. `finished`: the run's program and shaper have come to rest; `stopped`: a controlled stop has.

    `tip_correction_rad`: what the end-point feedback added to the rotary error; NaN on a rig without it.
    """

    joints: tuple[JointOutput, ...]
    segment: int
    finished: bool
    stopped: bool
    tip_correction_rad: float
