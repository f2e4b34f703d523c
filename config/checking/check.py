"""What can be said about a rig file with no hardware: does it hang together, which lines can the arm follow, what looks wrong.

`check` tells all of it. An error that the file alone decides also keeps the daemon from starting: a wrong file never becomes half a
start. What depends on today (a calibration that has run out) keeps the rig from being armed, and the daemon starts to say so.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable, Iterator

from config.checking.bus_budget import check_bus_budget
from config.checking.check_calibrations import check_calibrations, check_identified
from config.checking.check_devices import check_devices
from config.checking.check_hydraulics import check_hydraulics
from config.checking.check_limits import check_limits
from config.checking.check_plant import check_plant
from config.checking.check_runnable import check_runnable
from config.checking.check_sensors import check_sensors
from config.checking.check_servo import check_servo
from config.checking.check_signals import check_signals
from config.checking.check_tags import check_tags
from config.checking.finding import Finding, warning_at
from config.errors import ConfigError
from config.loading.load import LoadedRig, load_maneuver
from config.loading.shipped import shipped
from config.options.canopen_rig import proofs
from config.parsing.problems import config_error
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
    of_today = (finding for check in OF_TODAY for finding in check(loaded, tree, today))
    return [schema, *_of_the_file(rig, tree), *of_today]


def refuse_unusable(loaded: LoadedRig) -> None:
    """Returns for a rig that may be started. ConfigError with every error of OF_THE_FILE, each with file, line and column."""
    found = _of_the_file(loaded.rig, parse(loaded.text, loaded.path))
    problems = [finding.problem for finding in found if finding.problem is not None]
    if problems:
        raise config_error(loaded.path, problems)


def _of_the_file(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    return (finding for check in OF_THE_FILE for finding in check(rig, tree))


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


# What the file alone decides: an error of one of these keeps the daemon, and whatever else opens the devices, from starting.
OF_THE_FILE: tuple[Callable[[Rig, YamlTree], Iterator[Finding]], ...] = (
    check_runnable,
    check_devices,
    check_signals,
    _link,
    check_plant,
    check_tags,
    check_servo,
    check_hydraulics,
    check_sensors,
    check_limits,
    check_bus_budget,
    _proofs,
    _maneuvers,
)
# What the day decides as well: the rig starts disarmed and says why it can't be armed.
OF_TODAY: tuple[Callable[[LoadedRig, YamlTree, datetime.date], Iterator[Finding]], ...] = (check_calibrations, check_identified)
