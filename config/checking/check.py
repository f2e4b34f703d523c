"""What can be said about a rig file with no hardware: does it hang together, which lines can the arm follow, what looks wrong."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterator

from config.checking.bus_budget import check_bus_budget
from config.checking.check_devices import check_devices
from config.checking.check_hydraulics import check_hydraulics
from config.checking.check_identified import check_identified
from config.checking.check_limits import check_limits
from config.checking.check_plant import check_plant
from config.checking.check_sensors import check_sensors
from config.checking.check_servo import check_servo
from config.checking.check_signals import check_signals
from config.checking.check_tags import check_tags
from config.checking.finding import Finding, warning_at
from config.checking.unusable import unusable
from config.errors import ConfigError
from config.loading.load import LoadedRig, load_maneuver
from config.loading.shipped import shipped
from config.options.canopen_rig import proofs
from config.parsing.yaml_tree import YamlTree, parse
from config.schema.maneuver import JointSteps, Maneuver, StraightLine
from config.schema.rig import Rig

_INCH_M = 0.0254
_PAPER_HALF_LENGTH_M = 30 * _INCH_M  # the line of the Oak Ridge paper runs from x = -30 in to +30 in


def check_rig(loaded: LoadedRig, today: datetime.date) -> list[Finding]:
    """Every finding about a loaded rig. (A file with problems does not get here: load_rig reports those itself.)"""
    rig, tree = loaded.rig, parse(loaded.text, loaded.path)
    counts = f"{len(rig.joints)} joints, {len(rig.signals)} signals, {len(rig.devices)} devices"
    schema = Finding("ok", f"{loaded.path}: {rig.name}, {counts}; every key, unit and range of its sections is right")
    checks = (
        (Finding("error", problem.refusal.text()) for problem in unusable(rig, tree)),
        check_devices(rig, tree),
        check_signals(rig, tree, today),
        _link(rig, tree),
        check_identified(loaded, tree, today),
        check_plant(rig, tree),
        check_tags(tree),
        check_servo(rig, tree),
        check_hydraulics(rig, tree),
        check_sensors(rig, tree),
        check_limits(rig, tree),
        check_bus_budget(rig, tree),
        _proofs(rig, tree),
        _maneuvers(rig, tree),
    )
    return [schema, *(finding for check in checks for finding in check)]


def feasible_y0(rig: Rig, half_length_m: float) -> tuple[float, float] | None:
    """Smallest and largest distance y0 of a straight line from x = -half_length to +half_length that the joints' travel allows.

    The radius from the hub axis is y0 at the middle and sqrt(y0² + half_length²) at the ends; the rotary angle there is
    atan(half_length / y0). None when no line of this length fits.
    """
    shortest, longest = (travel + rig.arm.hub_offset_m for travel in rig.joints["prismatic"].travel)
    angle = min(-rig.joints["rotary"].travel[0], rig.joints["rotary"].travel[1])
    if longest <= half_length_m or angle <= 0:
        return None
    nearest = max(shortest, half_length_m / math.tan(angle) if angle < math.pi / 2 else 0.0)
    farthest = math.sqrt(longest**2 - half_length_m**2)
    return (nearest, farthest) if nearest <= farthest else None


def link_frequency_estimate_Hz(rig: Rig, extension_m: float) -> float:
    """First frequency of the clamped link with its payload by Rayleigh's method with the static shape (up to 1.5 % high).

    f = sqrt(3 EI / (L³ (M + 33/140 m L))) / 2π. The shapers use the same formula (`link_mode`), which config may not import.
    """
    link = rig.link_mode
    if link is None:
        raise ConfigError("the rig has no section 'link_mode'", where=rig.name)
    mass_kg = link.payload_kg + 33 / 140 * link.mass_per_length_kg_per_m * extension_m
    return math.sqrt(3 * link.bending_stiffness_N_m2 / (extension_m**3 * mass_kg)) / (2 * math.pi)


def _proofs(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    try:
        demanded = proofs(rig)
    except ConfigError:
        return  # the bus budget names what cannot be used
    for name, wanted in demanded.items():
        if not wanted:
            text = f"devices.{name}: demand_proof is false: it may be armed without knowing that it goes safe by itself"
            yield warning_at(tree, ("devices", name, "demand_proof"), text)


def _link(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    if rig.link_mode is None or rig.arm.kind != "rotary_prismatic":
        return
    shortest, longest = rig.joints["prismatic"].travel
    line = _range_text(feasible_y0(rig, _PAPER_HALF_LENGTH_M))
    yield Finding("ok", f"straight lines from x = -30 in to +30 in: {line}")
    low, high = link_frequency_estimate_Hz(rig, longest), link_frequency_estimate_Hz(rig, max(shortest, 1e-3))
    yield Finding(
        "ok", f"link mode about {low:.3g} Hz fully extended to {high:.3g} Hz retracted, payload {rig.link_mode.payload_kg:.4g} kg"
    )
    if high > rig.loop.rate_Hz / 10:
        text = f"the link mode reaches {high:.3g} Hz: the loop at {rig.loop.rate_Hz:g} Hz has fewer than 10 cycles a period"
        yield warning_at(tree, ("loop", "rate"), text)


def _maneuvers(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    usable, foreign = [], []
    for name, path in shipped("maneuvers").items():
        maneuver = load_maneuver(path).maneuver
        if not _has_the_joints(rig, maneuver):
            foreign.append(name)
        elif isinstance(maneuver, StraightLine) and (problem := _line_problem(maneuver, rig)):
            yield warning_at(tree, ("joints", "prismatic", "travel"), f"maneuver {name}: {problem}")
        else:
            usable.append(name)
    others = f"; for other arms: {', '.join(foreign)}" if foreign else ""
    yield Finding("ok", f"shipped maneuvers for this arm: {', '.join(usable) or 'none'}{others}")


def _has_the_joints(rig: Rig, maneuver: Maneuver) -> bool:
    if isinstance(maneuver, StraightLine):
        return rig.arm.kind == "rotary_prismatic"
    steps = maneuver.steps if isinstance(maneuver, JointSteps) else ()
    single = getattr(maneuver, "joint", None)  # most kinds move one joint
    named = {*getattr(maneuver, "start", {}), *(step.joint for step in steps), *([single] if single else [])}
    return named <= set(rig.joints)


def _line_problem(maneuver: StraightLine, rig: Rig) -> str:
    points = [maneuver.x_start_m]
    for move in maneuver.moves_m:
        points.append(points[-1] + move)
    half_length_m = max(map(abs, points))
    return _outside(feasible_y0(rig, half_length_m), maneuver.y0_m, half_length_m)


def _outside(allowed: tuple[float, float] | None, y0_m: float, half_length_m: float) -> str:
    if allowed and allowed[0] - 1e-9 <= y0_m <= allowed[1] + 1e-9:
        return ""
    return f"the line to x = ±{half_length_m / _INCH_M:.4g} in has y0 = {y0_m / _INCH_M:.4g} in; {_range_text(allowed)}"


def _range_text(allowed: tuple[float, float] | None) -> str:
    if allowed is None:
        return "none fits into the joints' travel"
    low, high = (bound / _INCH_M for bound in allowed)
    return f"y0 from {low:.2f} to {high:.2f} in fits into the joints' travel"
