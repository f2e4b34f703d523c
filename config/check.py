"""What can be said about a rig file with no hardware: does it hang together, which lines can the arm follow, what looks wrong."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterator

from config.bus_budget import check_bus_budget
from config.canopen_options import proofs
from config.check_identified import check_identified
from config.check_plant import check_plant
from config.errors import ConfigError
from config.finding import Finding
from config.load import LoadedRig, load_maneuver
from config.maneuver import JointSteps, Maneuver, StraightLine
from config.rig import Rig
from config.shipped import shipped

_INCH_M = 0.0254
_PAPER_HALF_LENGTH_M = 30 * _INCH_M  # the line of the Oak Ridge paper runs from x = -30 in to +30 in


def check_rig(loaded: LoadedRig, today: datetime.date) -> list[Finding]:
    """Every finding about a loaded rig. (A file with problems does not get here: load_rig reports those itself.)"""
    rig = loaded.rig
    counts = f"{len(rig.joints)} joints, {len(rig.signals)} signals, {len(rig.devices)} devices"
    schema = Finding("ok", f"{loaded.path}: {rig.name}, {counts}; every key, unit and range is right")
    checks = (
        _signal_ranges(rig),
        _ages(rig),
        _commands(rig),
        _calibrations(rig, today),
        _interlocks(rig),
        _link(rig),
        check_identified(loaded, today),
        check_plant(rig),
        check_bus_budget(rig),
        _proofs(rig),
        _maneuvers(rig),
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

    f = sqrt(3 EI / (L³ (M + 33/140 m L))) / 2π. The shapers use the same formula (control.link_mode), which config may not import.
    """
    link = rig.link_mode
    if link is None:
        raise ConfigError("the rig has no section 'link_mode'", where=rig.name)
    mass_kg = link.payload_kg + 33 / 140 * link.mass_per_length_kg_per_m * extension_m
    return math.sqrt(3 * link.bending_stiffness_N_m2 / (extension_m**3 * mass_kg)) / (2 * math.pi)


def _signal_ranges(rig: Rig) -> Iterator[Finding]:
    for name, joint in rig.joints.items():
        signal = rig.signals[f"{name}.position"]
        unit = "rad" if joint.motion == "rotary" else "m"
        for bound, limit, inside in (("low", signal.low, min), ("high", signal.high, max)):
            edge = inside(joint.travel)
            if limit is not None and inside(limit, edge) != limit:
                yield Finding(
                    "error", f"{name}.position: {bound} = {limit:.6g} {unit} lies inside the travel, which ends at {edge:.6g} {unit}"
                )


def _ages(rig: Rig) -> Iterator[Finding]:
    period_s = 1 / rig.loop.rate_Hz
    for name, signal in rig.signals.items():
        if signal.max_age_s < period_s:
            yield Finding(
                "error", f"{name}: max_age {signal.max_age_s:g} s is less than one period of the loop, {period_s:g} s: always stale"
            )
        if name.endswith(".position") and rig.devices[signal.device].slow:
            yield Finding("warning", f"{name} comes from the slow device {signal.device!r}: the servo will act on old positions")


def _commands(rig: Rig) -> Iterator[Finding]:
    for name, joint in rig.joints.items():
        needed_V = abs(rig.servo[name].velocity_feedforward) * joint.rate_limit
        if needed_V > joint.command_limit_V:
            yield Finding(
                "warning",
                f"joints.{name}: rate_limit needs {needed_V:.3g} V by the feed-forward, command_limit is {joint.command_limit_V:g} V:"
                " the joint cannot reach its rate limit",
            )


def _calibrations(rig: Rig, today: datetime.date) -> Iterator[Finding]:
    for name, signal in rig.signals.items():
        until = signal.calibration.valid_until
        if until and until < today:
            blocks = signal.calibration.on_expiry == "block"
            what = f"{name}: the calibration was valid until {until}: calibrate again"
            yield Finding("error", f"{what}; the rig cannot be armed") if blocks else Finding("warning", what)


def _interlocks(rig: Rig) -> Iterator[Finding]:
    fitted = {name.rsplit(".", 1)[-1] for name in rig.signals}
    pairs = (
        ("supply_pressure", "supply_pressure_min", rig.interlocks.supply_pressure_min_Pa),
        ("return_pressure", "return_pressure_max", rig.interlocks.return_pressure_max_Pa),
        ("reservoir_temperature", "oil_temperature_max", rig.interlocks.oil_temperature_max_C),
    )
    for signal, key, limit in pairs:
        if signal in fitted and limit is None:
            yield Finding("warning", f"{signal} is measured but interlocks.{key} is not set: nothing stops the arm on it")


def _proofs(rig: Rig) -> Iterator[Finding]:
    try:
        demanded = proofs(rig)
    except ConfigError:
        return  # the bus budget names what cannot be used
    for name, wanted in demanded.items():
        if not wanted:
            yield Finding("warning", f"devices.{name}: demand_proof is false: it may be armed without knowing that it goes safe by itself")


def _link(rig: Rig) -> Iterator[Finding]:
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
        yield Finding(
            "warning", f"the link mode reaches {high:.3g} Hz: the loop at {rig.loop.rate_Hz:g} Hz has fewer than 10 cycles a period"
        )


def _maneuvers(rig: Rig) -> Iterator[Finding]:
    usable, foreign = [], []
    for name, path in shipped("maneuvers").items():
        maneuver = load_maneuver(path).maneuver
        if not _has_the_joints(rig, maneuver):
            foreign.append(name)
        elif isinstance(maneuver, StraightLine) and (problem := _line_problem(maneuver, rig)):
            yield Finding("warning", f"maneuver {name}: {problem}")
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
