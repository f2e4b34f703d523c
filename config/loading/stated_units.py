"""The units in which a rig file states its signals and joints: what an operator reads should look like what he wrote."""

from __future__ import annotations

from config.errors import UnitError
from config.parsing.yaml_tree import parse
from config.stated_sentences import Conversion
from config.units import from_si, is_stored, written_unit

_RATES = ("", "/s", "/s^2")
_OF_A_DISK = "1 MB"  # nobody reads 7e10 bytes
_PAYLOAD = "payload"
_IN_SENTENCES = ("Pa", "degC", "rad", "rad/s", "rad/s^2", "m", "m/s", "m/s^2", "bytes")


def stated_units(text: str) -> dict[str, str]:
    """Signal, joint or "disk space" → the unit of its range in the rig file; those stated as bare numbers are left out."""
    plain = parse(text, "rig.yaml").plain
    ranges = {name: (signal.get("low"), signal.get("high")) for name, signal in plain.get("signals", {}).items()}
    ranges |= {name: tuple(joint.get("travel", ())) for name, joint in plain.get("joints", {}).items()}
    ranges["disk space"] = (plain.get("interlocks", {}).get("disk_free_min"), _OF_A_DISK)
    units = {name: next(filter(None, map(written_unit, values)), "") for name, values in ranges.items()}
    return {name: unit for name, unit in units.items() if unit}


def conversion(unit: str, stated: str) -> Conversion | None:
    """From an SI unit to the stated one, its rate or its acceleration, whichever it can be; None when it is none of them."""
    for rate in _RATES if is_stored(unit) else ():
        if not unit.endswith(rate):
            continue
        shown = stated + rate
        try:
            zero, one = from_si(0.0, unit, shown), from_si(1.0, unit, shown)
        except UnitError:
            continue
        return shown, one - zero, zero
    return None


def conversions(units: dict[str, str], stated: dict[str, str]) -> dict[str, Conversion]:
    """Of every name that is, or begins with, a stated one ("rotary.supply_pressure limit"). `units`: name → SI unit."""
    found = {}
    for name, unit in units.items():
        owner = max((each for each in stated if name == each or name.startswith(f"{each} ")), key=len, default="")
        shown = conversion(unit, stated[owner]) if owner and unit else None
        if shown is not None:
            found[name] = shown
    return found


def sentence_units(text: str) -> dict[str, dict[str, Conversion]]:
    """Joint, signal or payload → SI unit → how the rig file states it: for sentences, which name them. Joints first, then the order of
    the file."""
    stated, plain = stated_units(text), parse(text, "rig.yaml").plain
    owners = sorted(stated, key=lambda name: name not in plain.get("joints", {}))
    found = {name: {unit: shown for unit in _IN_SENTENCES if (shown := conversion(unit, stated[name]))} for name in owners}
    mass = conversion("kg", written_unit(plain.get("link_mode", {}).get(_PAYLOAD)))
    return {name: units for name, units in found.items() if units} | ({_PAYLOAD: {"kg": mass}} if mass else {})
