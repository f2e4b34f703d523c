"""What could be run next: every shipped maneuver, and forms of them whose size follows from this rig's limits.

A design is a shipped maneuver and the keys of it that are changed, as `longreach start NAME --set KEY=VALUE` takes them. Sizes are
shares of the safety envelope: travel, rate and acceleration limits, and for signals on the command what the following error allows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from config.loading.load import load_maneuver
from config.loading.shipped import shipped
from config.schema.maneuver import JointManeuver, maneuver_content
from config.schema.rig import Rig
from servo_control.path.joint_limits import JointLimits, joint_limits

MARGIN = 0.9  # share of a limit that a design may ask for: the model that plans it is known to be wrong
_LEAST_CYCLES = 25  # of the loop in one period of the highest frequency
_LEAST_V = 0.1

Parameters = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class ManeuverDesign:
    """A shipped maneuver with changed keys (values as in the file, with units)."""

    name: str
    parameters: Parameters = field(default_factory=dict)

    @property
    def content(self) -> dict[str, Any]:
        """The maneuver as a run request has it."""
        return maneuver_content(load_maneuver(self.name).maneuver) | dict(self.parameters)

    @property
    def label(self) -> str:
        """`multisine (joint rotary, on command, to 40 Hz)`."""
        changes = ", ".join(f"{key} {value}" for key, value in self.parameters.items() if key != "start")
        return f"{self.name} ({changes})" if changes else self.name

    @property
    def smaller(self) -> ManeuverDesign | None:
        """Half the power on the command; None for what has none, or is small already."""
        value, _, unit = str(self.parameters.get("amplitude", "")).partition(" ")
        if unit != "V" or float(value) < _LEAST_V:
            return None
        return ManeuverDesign(self.name, {**self.parameters, "amplitude": f"{float(value) * np.sqrt(0.5):.3g} V"})

    @property
    def request(self) -> dict[str, Any]:
        """For `start` of the daemon."""
        return {"maneuver": {"name": self.name}, "parameters": dict(self.parameters), "approach": True}


def designs(rig: Rig, joints: Sequence[str], thorough: bool = True) -> list[ManeuverDesign]:
    """Forms that move the given joints; with `thorough` also every maneuver as it is shipped."""
    found = [ManeuverDesign(name) for name in shipped("maneuvers")] if thorough else []
    for limits in joint_limits(rig):
        if limits.name in joints:
            found += [ManeuverDesign(name, parameters) for name, parameters in _forms(rig, limits)]
    return found


def _forms(rig: Rig, joint: JointLimits) -> Iterator[tuple[str, Parameters]]:
    """Slow and fast, small and large, on the reference and on the command: what tells friction, flow and delays apart differs in these."""
    start = _start(rig, "multisine")
    here = float(start[joint.name].split()[0])
    low, high = joint.travel
    room = MARGIN * min(high - here, here - low)
    unit, rate = joint.unit, MARGIN * joint.rate
    at: dict[str, Any] = {"start": start, "joint": joint.name}
    for share in (0.01, 0.15):
        amplitude = min(room, share * rate)
        yield "slow_triangle", at | {"amplitude": f"{amplitude:.4g} {unit}", "rate": f"{share * rate:.4g} {unit}/s"}
    for step in (0.004 * (high - low), min(room / 3, 0.3 * rate)):
        yield "staircase", at | {"step": f"{step:.4g} {unit}", "steps": 3, "hold": "0.8 s"}
    for share in (0.25, 1.0):
        pace = {"speed": f"{share * rate:.4g} {unit}/s", "acceleration": f"{share * MARGIN * joint.acceleration:.4g} {unit}/s^2"}
        yield "fast_strokes", at | pace | {"by": f"{min(room, 0.8 * share * rate):.4g} {unit}", "strokes": 4, "hold": "0.6 s"}
    yield from (("multisine", at | wave) for wave in _waves(rig, joint))


def _waves(rig: Rig, joint: JointLimits) -> Iterator[dict[str, Any]]:
    """Signals on the command: low and high band, small and as large as the servo can hold the arm against."""
    most = min(joint.command_V, rig.joints[joint.name].following_error_limit * abs(rig.servo[joint.name].gain))
    highest = rig.loop.rate_Hz / _LEAST_CYCLES
    # The last is all where delays and lags differ most: lower lines move the joint far for little that tells, up to its following error.
    bands = ((0.3, 6.0, 0.2), (0.3, 6.0, 0.8), (2.0, highest, 0.2), (2.0, highest, 0.8), (highest / 4, highest, 0.8))
    for low, high, share in bands:
        band = {"from": f"{low:g} Hz", "to": f"{high:g} Hz", "period": "4 s", "periods": 2, "lines": 24}
        yield {"on": "command", "amplitude": f"{share * most:.3g} V", "fade": "0.5 s", "crest_limit": 3} | band


def _start(rig: Rig, name: str) -> dict[str, str]:
    """Where the shipped maneuver starts when it knows this rig's joints, else the middle of every travel."""
    maneuver = load_maneuver(name).maneuver
    given = maneuver.start if isinstance(maneuver, JointManeuver) else {}
    if set(given) == set(rig.joints):
        return {joint: str(position) for joint, position in given.items()}
    return {joint.name: f"{sum(joint.travel) / 2:.4g} {joint.unit}" for joint in joint_limits(rig)}
