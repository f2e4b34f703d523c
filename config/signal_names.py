"""The names a signal may have, and what each measures: `rotary.position`, `rotary.supply_pressure`, `reservoir_temperature`."""

from __future__ import annotations

from collections.abc import Mapping

SECOND_POSITION = "second_position"  # another sensor of a joint's motion: logged and compared, the servo never sees it
JOINT_SIGNALS = {
    "position": "position",
    SECOND_POSITION: "position",
    "supply_pressure": "pressure",
    "return_pressure": "pressure",
    "supply_temperature": "temperature",
    "return_temperature": "temperature",
    "pressure_a": "pressure",
    "pressure_b": "pressure",
}
RIG_SIGNALS = {"tip.acceleration": "acceleration", "tip.deflection": "length", "reservoir_temperature": "temperature"}


def signal_measures(motion_of_joint: Mapping[str, str]) -> dict[str, str]:
    """Every signal name this rig can have and what it measures, for joints given as {name: "rotary" | "linear"}."""
    known: dict[str, str] = {}
    for joint, motion in motion_of_joint.items():
        position = {"rotary": "angle", "linear": "length"}.get(motion, "unknown")
        known |= {f"{joint}.{name}": position if measures == "position" else measures for name, measures in JOINT_SIGNALS.items()}
    return known | RIG_SIGNALS
