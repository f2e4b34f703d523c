"""What keys mean: which joint or way, how fast, and that nothing moves unless a key keeps repeating. No terminal and no clock here.

A key counts for DEAD_MAN_S after it was last heard of. A keyboard repeats a held key every 30 to 90 ms, so the arm moves while
it is held; the gap before the first repeat (often 0.25 to 0.6 s) is longer, so that a tap is a nudge.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

DEAD_MAN_S = 0.12  # with the way to the loop less than 150 ms
SPEEDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)  # of the limits of the run
FIRST_SPEED = 0.1
WAYS = {"left": (0, 1.0), "right": (0, -1.0), "up": (1, 1.0), "down": (1, -1.0)}  # axis and sign of a joint: anticlockwise and out
TIP_WAYS = {"left": (0, -1.0), "right": (0, 1.0), "up": (1, 1.0), "down": (1, -1.0)}  # of x and y in the plane


@dataclass(frozen=True, slots=True)
class SteeredMotion:
    """What a set point asks for: rates by joint, or (x, y) of the tip in m/s."""

    rates: Mapping[str, float]
    tip_mps: tuple[float, float] | None = None

    @property
    def moves(self) -> bool:
        return any(self.tip_mps or self.rates.values())


class Steering:
    """Keys in, motion out. `answer` is the daemon's to `stream`."""

    def __init__(self, answer: Mapping[str, Any], tip: bool = False, speed: float = FIRST_SPEED) -> None:
        self._rates = {name: float(limits["rate"]) for name, limits in answer["limits"].items()}
        self._tip_speed = float(answer["tip_speed_mps"])
        self.tip = tip and self.has_tip
        self.speed = speed
        self._key, self._heard_s = "", 0.0

    @property
    def has_tip(self) -> bool:
        return self._tip_speed > 0.0

    @property
    def rates(self) -> dict[str, float]:
        """Of a joint that moves, in rad/s or m/s."""
        return {name: self.speed * rate for name, rate in self._rates.items()}

    @property
    def tip_speed_mps(self) -> float:
        return self.speed * self._tip_speed

    def press(self, key: str, now_s: float) -> None:
        """A key that was pressed or has repeated; the newest counts."""
        if key in WAYS:
            self._key, self._heard_s = key, now_s
        elif key in "+=-":
            self._change_speed(-1 if key == "-" else 1)
        elif key == "t":
            self.tip = self.has_tip and not self.tip
            self._key = ""
        else:
            self._key = ""

    def release(self, key: str) -> None:
        """Where the terminal tells it: sooner than the time-out."""
        if key == self._key:
            self._key = ""

    def motion(self, now_s: float) -> SteeredMotion:
        """What is asked for now; no motion once the key has been silent too long."""
        if now_s - self._heard_s > DEAD_MAN_S:
            self._key = ""
        if self.tip:
            return SteeredMotion({}, self._tip_motion())
        axis, sign = WAYS.get(self._key, (-1, 0.0))
        return SteeredMotion({name: sign * rate for number, (name, rate) in enumerate(self.rates.items()) if number == axis})

    def _tip_motion(self) -> tuple[float, float]:
        axis, sign = TIP_WAYS.get(self._key, (-1, 0.0))
        speed = sign * self.tip_speed_mps
        return (speed if axis == 0 else 0.0, speed if axis == 1 else 0.0)

    def _change_speed(self, step: int) -> None:
        at = min(range(len(SPEEDS)), key=lambda n: abs(SPEEDS[n] - self.speed))
        self.speed = SPEEDS[max(0, min(len(SPEEDS) - 1, at + step))]


def keys_of(joints: Sequence[str]) -> str:
    """For the operator: which keys move which joint."""
    pairs = ("← →", "↑ ↓")
    return ", ".join(f"{keys} {joint}" for keys, joint in zip(pairs, joints, strict=False))
