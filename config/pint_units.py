"""Every unit that pint knows, with those of hydraulics: the units that `unit_factors` does not list, and what wrote that table.

    python -m config.pint_units        writes config/unit_factors.py

Angle and information are dimensions of their own here, unlike in SI: otherwise a corner of "5 Hz" would be accepted as 5 rad/s, a gain
of "0.35 V" as 0.35 V/rad, and "10 %" of a disk as 0.0125 bytes. Only `units` imports this, and only for a unit outside the table: pint
and its definitions take 0.4 s.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import pint

_DEFINITIONS = (
    "radian = [angle] = rad",
    "bit = [information]",
    "rpm = turn / minute",
    "rps = turn / second",
    "gpm = gallon / minute",
    "lpm = liter / minute",
    "cSt = 1e-6 * meter ** 2 / second",
)

# What the files, the schema and the log store. A quantity of a schema in another unit works, but its rig starts slower.
STORED = (
    *("", "Pa", "m", "m^2", "m^3", "m^4", "rad", "s", "Hz", "kg", "N", "N*m", "V", "W", "J", "K", "degC", "bytes", "bit/s"),
    *("m/s", "m/s^2", "rad/s", "rad/s^2", "V/s", "Pa/s", "m^3/s", "m^2/s", "m^3/rad", "m^3/s/Pa", "m^3/s/V", "V/m", "V/rad"),
    *("V*s/m", "V*s/rad", "V*s^2/m", "V*s^2/rad", "s/m", "s/rad", "N/m", "N*m/rad", "N*s/m", "N*m*s/rad", "N*m^2", "N/V", "N*m/V"),
    *("m/s/V", "rad/s/V", "kg/m", "kg/m^3", "kg*m^2", "J/K", "J/kg/K", "W/K", "1/K", "1/V", "1/m", "1/m^3", "1/Pa", "1/Pa^3", "N/Pa"),
    *("Pa*s^2/m^6", "N*m/Pa", "m/V", "rad/V", "Pa/V", "K/s"),
)
_LENGTHS, _ANGLES, _TIMES = ("m", "cm", "mm", "um", "in", "ft"), ("rad", "mrad", "deg", "turn"), ("s", "ms", "us", "ns", "min", "h")
_VOLTAGES, _FORCES, _TORQUES = ("V", "mV"), ("N", "kN", "lbf"), ("N*m", "kN*m", "lbf*in", "lbf*ft")
_PRESSURES, _VOLUMES = ("Pa", "kPa", "MPa", "GPa", "bar", "mbar", "psi", "ksi"), ("m^3", "cm^3", "mm^3", "in^3", "L", "l", "mL", "gal")
_TEMPERATURES = ("degC", "degF", "K", "°C", "°F")
_TURNS_AND_LENGTHS = (*_LENGTHS, *_ANGLES)


def written_units() -> list[str]:
    """What users of hydraulics write: the stored units, the usual ones of each kind, and those composed of them."""
    simple = (*_TURNS_AND_LENGTHS, *_TIMES, *_VOLTAGES, *_FORCES, *_TORQUES, *_PRESSURES, *_VOLUMES)
    other = ("%", "ppm", "km", "inch", "inches", "arcmin", "arcsec", "degree", "degrees", "day", "days", "kHz", "MHz", "rpm")
    masses = ("g", "mg", "t", "lb", "lbs", "g_0", "mg_0", "kW", "kJ", "hp", "delta_degC", "delta_degF", "A", "mA")
    flows = ("lpm", "gpm", "L/min", "l/min", "mL/min", "cm^3/s", "cm^3/min", "in^3/s", "in^3/min", "mm^3/s", "gal/min", "cSt", "mm^2/s")
    data = ("kB", "MB", "GB", "kbit/s", "Mbit/s", "kB/s", "MB/s", "B", "B/s", "bit", "kg/L", "g/cm^3", "kg/cm", "g/m", "lb/ft", "lb/in^3")
    heat = ("kJ/K", "kJ/kg/K", "kW/K", "%/K", "1/GPa", "1/MPa", "1/bar", "1/psi", "1/MPa^3", "cm^2", "mm^2", "in^2", "mm^4", "cm^4", "in^4")
    composed = [
        *_joined(_TURNS_AND_LENGTHS, "/", ("s", "s^2", "min", "s/V")),
        *_joined(_PRESSURES, "/", ("s", "min", "V")),
        *_joined(_VOLTAGES, "/", (*_TURNS_AND_LENGTHS, "s", "ms")),
        *_joined(("V*s", "V*s^2", "mV*s", "s", "ms"), "/", _TURNS_AND_LENGTHS),
        *_joined((*_FORCES, "N*s", "kN*s"), "/", (*_LENGTHS, "V")),
        *_joined((*_TORQUES, "N*m*s"), "/", ("rad", "deg", "V")),
        *_joined(("m^3", "cm^3", "in^3", "mL", "L"), "/", ("rad", "deg", "turn", "s/Pa", "s/bar", "s/V")),
        *_joined(("kg", "g", "lb"), "*", ("m^2", "cm^2", "in^2")),
    ]
    return list(dict.fromkeys((*STORED, *simple, *other, *masses, *flows, *data, *heat, *composed)))


def _joined(first: tuple[str, ...], sign: str, second: tuple[str, ...]) -> list[str]:
    return [f"{one}{sign}{other}" for one, other in product(first, second)]


@cache
def registry() -> pint.UnitRegistry[float]:
    """pint's units with ours. It starts empty: one made with pint's own definitions has already cached angle as dimensionless."""
    units: pint.UnitRegistry[float] = pint.UnitRegistry(None, on_redefinition="ignore")
    units.load_definitions(Path(pint.__file__).with_name("default_en.txt"))
    for definition in _DEFINITIONS:
        units.define(definition)
    return units


def converted(value: float, unit: str, wanted: str) -> float:
    """`value` in `unit` expressed in `wanted`. ValueError: another dimension; LookupError: a text that is no unit."""
    try:
        quantity = registry().Quantity(value, unit or "dimensionless")
        if any(_misleads(name) for name, _ in quantity.unit_items()):
            raise LookupError(f"{unit} is none of ours")
        return float(quantity.to(wanted or "dimensionless").magnitude)
    except pint.DimensionalityError as error:
        raise ValueError(str(error)) from error
    except Exception as error:  # pint raises tokenizer, attribute and zero-division errors for unreadable unit text
        raise LookupError(str(error)) from error


def _misleads(name: str) -> bool:
    """Decibels, which would turn a gain of -6 into one of 0.25, and pint's angular mil, which is a tenth of anyone else's."""
    return name == "mil" or bool(getattr(registry()._units[name].converter, "is_logarithmic", False))


def factors() -> dict[str, dict[str, float]]:
    """Stored unit → written unit → factor, for every pair of one dimension without an offset."""
    written = written_units()
    found = {stored: {unit: factor for unit in written if (factor := _factor(unit, stored)) is not None} for stored in STORED}
    for rate in ("", "/s"):  # "K" is a difference of temperatures
        found[f"K{rate}"] |= {f"{unit}{rate}": found["K"][f"delta_{unit}"] for unit in ("degC", "degF")}
    return found


def _factor(unit: str, stored: str) -> float | None:
    if "degC" in (unit, stored):
        return None
    try:
        return converted(1.0, unit, stored)
    except ValueError:
        return None


def temperatures() -> dict[str, tuple[float, float]]:
    """Temperature unit → scale and offset: kelvin = scale × value + offset."""
    converters: dict[str, Any] = {unit: registry()._units[str(registry().Unit(unit))].converter for unit in _TEMPERATURES}
    return {unit: (float(each.scale), float(getattr(each, "offset", 0.0))) for unit, each in converters.items()}


def table_text() -> str:
    """The source of config/unit_factors.py."""
    rows = "\n".join(f"    {stored!r}: {{\n{_wrapped(units)}\n    }}," for stored, units in factors().items())
    return _HEAD.format(rows=rows, temperatures=_wrapped(temperatures()))


def _wrapped(entries: Mapping[str, object]) -> str:
    text = " ".join(f"{name!r}:~{value!r},".replace(" ", "~") for name, value in entries.items())
    return textwrap.fill(text, 128, initial_indent=" " * 8, subsequent_indent=" " * 8, break_long_words=False).replace("~", " ")


_HEAD = '''"""Factors between stored units and written ones, as pint has them. Written by `python -m config.pint_units`: not to be edited.

FACTORS: stored unit → written unit → factor, complete for the units that stand anywhere in it: what is missing is of another dimension.
TEMPERATURES: unit → scale and offset to kelvin.
"""

# fmt: off

FACTORS: dict[str, dict[str, float]] = {{
{rows}
}}

TEMPERATURES: dict[str, tuple[float, float]] = {{
{temperatures}
}}
'''

if __name__ == "__main__":
    Path(__file__).with_name("unit_factors.py").write_text(table_text(), encoding="utf-8")
