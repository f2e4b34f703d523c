"""What goes into and comes out of `Controller.step`: plain values only, so that a log re-executes bit for bit (docs/method/log.md)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple


class Mode(IntEnum):
    """Modes of the daemon; the number is what the log stores."""

    DISARMED = 0
    ARMING = 1
    HOLDING = 2
    RUNNING = 3
    STOPPING = 4
    FAULT = 5
    PROVING = 6


SERVO_ACTS = frozenset((int(Mode.HOLDING), int(Mode.RUNNING), int(Mode.STOPPING)))  # as the facts have a mode


class Wanted(IntEnum):
    """What a set point asks for; the number is what the log stores."""

    RATE = 1  # of every joint, in rad/s or m/s
    TARGET = 2  # position of every joint, in rad or m
    TIP = 3  # velocity of the tip in the plane, (x, y) in m/s
    END = 4  # come to rest: the run is over
    CLIENT_LEFT = 5  # whoever drove has hung up


class SetPoint(NamedTuple):
    """One request of whoever drives by hand, as it reached the loop.

    `values` are of every joint, or (x, y). `late_s`: how much longer it was on its way than the quickest one, where that is known.
    """

    run: int
    wanted: int
    values: tuple[float, ...]
    late_s: float


class Driving(NamedTuple):
    """How a run that is driven by hand goes: the numbers that the checks of set points read; zeros in any other run.

    `reach` is the largest share of its limit that a set point has asked for; `unusable` counts numbers that are not finite.
    """

    silent_s: float = 0.0
    late_s: float = 0.0
    unusable: float = 0.0
    reach: float = 0.0
    client_left: float = 0.0


NOT_DRIVEN = Driving()


@dataclass(slots=True)
class Inputs:
    """One cycle's inputs. `position` is in the order of `rig.joints`; NaN where a sensor is not fitted or failed.

    `set_point`: one that arrived for this cycle; None in most.
    """

    cycle: int
    mode: int
    run: int  # number of the prepared run; 0 when there is none
    position: tuple[float, ...]
    tip_deflection_m: float
    tip_acceleration_mps2: float
    oil_temperature_C: tuple[float, ...] = ()  # of every joint's oil compensation, in the order of the joints; empty when none has one
    set_point: SetPoint | None = None


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
    driving: Driving = NOT_DRIVEN
