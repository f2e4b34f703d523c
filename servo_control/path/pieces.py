"""The pieces a program is made of. Each gives, for its own time t in s, where the joints should be and how fast they move.

A sample is (positions, rates, accelerations, volts): one value a joint, in rad or m and in the order of `rig.joints`; volts are
added to the command.
"""

from __future__ import annotations

from typing import Literal, Protocol

from servo_control.link.kinematics import inverse, inverse_motion
from servo_control.path.corrected_path import Path
from servo_control.path.trajectory import Trapezoid
from servo_control.path.waves import Wave

Vector = tuple[float, ...]
Sample = tuple[Vector, Vector, Vector, Vector]
Kind = Literal["move", "hold"]


class Piece(Protocol):
    """A named part of a program; `at` is defined on 0 ≤ t ≤ duration_s."""

    name: str
    kind: Kind
    duration_s: float

    def at(self, t: float) -> Sample: ...


class Dwell:
    """The joints stay where they are."""

    __slots__ = ("_sample", "duration_s", "kind", "name")

    def __init__(self, name: str, positions: Vector, duration_s: float) -> None:
        zero = (0.0,) * len(positions)
        self.name = name
        self.kind: Kind = "hold"
        self.duration_s = duration_s
        self._sample: Sample = (positions, zero, zero, zero)

    def at(self, t: float) -> Sample:
        return self._sample


class JointMove:
    """Straight in joint space: all joints start and stop together, the slowest one sets the time."""

    __slots__ = ("_distance", "_end", "_start", "_zero", "duration_s", "kind", "name", "path")

    def __init__(self, name: str, start: Vector, end: Vector, speeds: Vector, accelerations: Vector) -> None:
        self.name = name
        self.kind: Kind = "move"
        self._start, self._end = start, end
        self._distance = tuple(b - a for a, b in zip(start, end, strict=True))
        moving = [j for j, d in enumerate(self._distance) if d != 0.0]
        speed = min((speeds[j] / abs(self._distance[j]) for j in moving), default=1.0)
        acceleration = min((accelerations[j] / abs(self._distance[j]) for j in moving), default=1.0)
        self.path: Path = Trapezoid(1.0 if moving else 0.0, speed, acceleration)
        self._zero = (0.0,) * len(start)
        self.duration_s = self.path.duration_s

    def place(self, s: float) -> Vector:
        """Joint positions at a path position, 0 to 1."""
        return tuple([a + s * d for a, d in zip(self._start, self._distance, strict=True)])

    def at(self, t: float) -> Sample:
        if t >= self.duration_s:
            return self._end, self._zero, self._zero, self._zero
        s, rate, acceleration = self.path.at(t)
        return (
            self.place(s),
            tuple([rate * d for d in self._distance]),
            tuple([acceleration * d for d in self._distance]),
            self._zero,
        )


class LineMove:
    """Along X at constant y0, exact in path speed and acceleration; joints are (rotary, prismatic)."""

    __slots__ = ("_hub_offset_m", "_x_start", "_y0", "duration_s", "kind", "name", "path")

    def __init__(self, name: str, x_start: float, path: Trapezoid, y0: float, hub_offset_m: float) -> None:
        self.name = name
        self.kind: Kind = "move"
        self.path: Path = path
        self._x_start, self._y0, self._hub_offset_m = x_start, y0, hub_offset_m
        self.duration_s = path.duration_s

    def place(self, s: float) -> Vector:
        """Joint positions at a path position in m."""
        return inverse(self._x_start + s, self._y0, self._hub_offset_m)

    def at(self, t: float) -> Sample:
        s, speed, acceleration = self.path.at(t)
        motion = inverse_motion((self._x_start + s, self._y0), (speed, 0.0), (acceleration, 0.0), self._hub_offset_m)
        return motion.position, motion.rate, motion.acceleration, (0.0, 0.0)


class Excited:
    """A wave added to one joint: to its held position, or to its command in volts while the reference stays."""

    __slots__ = ("_joint", "_on_command", "_positions", "_wave", "duration_s", "kind", "name")

    def __init__(self, name: str, positions: Vector, joint: int, wave: Wave, *, on_command: bool) -> None:
        self.name = name
        self.kind: Kind = "move"
        self._positions, self._joint, self._wave, self._on_command = positions, joint, wave, on_command
        self.duration_s = wave.duration_s

    def at(self, t: float) -> Sample:
        value, rate, acceleration = self._wave.at(t)
        if self._on_command:
            zero = (0.0,) * len(self._positions)
            return self._positions, zero, zero, self._only(value)
        positions = list(self._positions)
        positions[self._joint] += value
        return tuple(positions), self._only(rate), self._only(acceleration), (0.0,) * len(positions)

    def _only(self, value: float) -> Vector:
        return tuple([value if j == self._joint else 0.0 for j in range(len(self._positions))])
