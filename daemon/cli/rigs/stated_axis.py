"""From the answers to one hydraulic axis: its numbers in SI, and as they were given for the file."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from math import pi
from typing import TYPE_CHECKING

from daemon.cli.rigs.questions import grade, number

if TYPE_CHECKING:
    from tuning.new_rig.axis import Axis
    from tuning.new_rig.rig_text import Stated

Pair = tuple[float, float]


def stated(arguments: argparse.Namespace, given: Mapping[str, str], assumed: frozenset[str], size: Mapping[str, str], kind: str) -> Stated:
    """What goes into the file as the user wrote it."""
    from tuning.new_rig.rig_text import Stated

    return Stated(
        name=arguments.name,
        description=arguments.description or f"{kind} {arguments.name}",
        joint=given["joint"],
        size=size,
        mass=given.get("inertia", given.get("mass", "")),
        rated_flow=given["rated_flow"],
        rated_drop=given["rated_drop"],
        full_scale=given["full_scale"],
        stroke_time=given["stroke_time"],
        supply=given["supply"],
        iso_vg=grade(given["iso_vg"]),
        position={key: given[key] for key in ("resolution", "noise")},
        chamber_pressures=arguments.chamber_pressures,
        assumed=assumed,
    )


def axis_of(given: Mapping[str, str], rotary: bool) -> tuple[Axis, dict[str, str]]:
    """The axis in SI, and the lines of the actuator's size for the file."""
    from tuning.new_rig.axis import Axis

    (area_a, area_b), (low, high), size = _vane(given) if rotary else _cylinder(given)
    own = "rad" if rotary else "m"
    return Axis(
        rotary, area_a, area_b, low, high,
        mass=number(given["inertia"], "kg*m^2") if rotary else number(given["mass"], "kg"),
        dead_volume=number(given["dead_volume"], "m^3"),
        rated_flow=number(given["rated_flow"], "m^3/s"),
        rated_drop=number(given["rated_drop"], "Pa"),
        full_scale_V=number(given["full_scale"], "V"),
        stroke_time_s=number(given["stroke_time"], "s"),
        supply=number(given["supply"], "Pa"),
        resolution=number(given["resolution"], own),
        noise=number(given["noise"], own),
    ), size  # fmt: skip


def _vane(given: Mapping[str, str]) -> tuple[Pair, Pair, dict[str, str]]:
    """Areas (m³/rad), ends of travel (rad, about the middle) and size of a rotary actuator, whose chambers are alike."""
    displacement, half = number(given["displacement"], "m^3/rad"), 0.5 * number(given["angle"], "rad")
    volume = f"{1e6 * (number(given['dead_volume'], 'm^3') + half * displacement):.5g} cm^3"
    size = {
        "displacement": f"{given['displacement']}  # [DS]",
        "volume_a": f"{volume}  # [D] half of the angle and the lines",
        "volume_b": f"{volume}  # [D]",
    }
    return (displacement, displacement), (-half, half), size


def _cylinder(given: Mapping[str, str]) -> tuple[Pair, Pair, dict[str, str]]:
    """Areas of both sides (m²), ends of travel (m) and size of a cylinder with one rod."""
    bore, rod, stroke = (number(given[name], "m") for name in ("bore", "rod", "stroke"))
    dead = f"{given['dead_volume']}  # [C]"
    size = {"bore": f"{given['bore']}  # [DS]", "rod": f"{given['rod']}  # [DS]", "dead_volume_a": dead, "dead_volume_b": dead}
    return (pi / 4 * bore**2, pi / 4 * (bore**2 - rod**2)), (0.0, stroke), size
