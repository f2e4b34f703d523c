"""The one place where units are converted: what a user writes ("2000 psi") becomes a float in SI (temperatures in degC).

Angle is a dimension of its own here, unlike in SI: otherwise a corner of "5 Hz" would be accepted as 5 rad/s, and a gain of
"0.35 V" as 0.35 V/rad.
"""

from __future__ import annotations

import math
import re
from functools import cache, lru_cache
from pathlib import Path

import pint

from config.errors import UnitError

_NUMBER_AND_UNIT = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)$")

_DEFINITIONS = (
    "radian = [angle] = rad",
    "rpm = turn / minute",
    "rps = turn / second",
    "gpm = gallon / minute",
    "lpm = liter / minute",
    "cSt = 1e-6 * meter ** 2 / second",
)


@cache
def registry() -> pint.UnitRegistry[float]:
    """The unit registry, with hydraulic units and with angle as a dimension. Built once: it costs about 0.1 s.

    It starts empty because a registry made with pint's own definitions has already cached angle as dimensionless.
    """
    units: pint.UnitRegistry[float] = pint.UnitRegistry(None, on_redefinition="ignore")
    units.load_definitions(Path(pint.__file__).with_name("default_en.txt"))
    for definition in _DEFINITIONS:
        units.define(definition)
    return units


@lru_cache(maxsize=4096, typed=True)
def to_si(text: str | float, unit: str) -> float:
    """Convert what the user wrote to `unit`; a bare number is taken to be in `unit` already.

    `unit` is a pint expression such as "Pa", "m", "V/rad", "degC" or "" (dimensionless). "K" is a temperature difference
    (temperatures themselves are kept in degC), so "0.1 degC" and "0.18 degF" are both 0.1 K.
    Raises UnitError with the value and the wanted unit when the text is not a quantity or the dimensions differ.
    """
    if isinstance(text, bool):
        raise UnitError("a number was expected", value=text, unit=unit)
    if isinstance(text, (int, float)):
        return _finite(float(text), unit)
    match = _NUMBER_AND_UNIT.match(text)
    if not match:
        raise UnitError("not a number with a unit", value=repr(text), next_step=_advice(unit))
    number, written = float(match[1]), match[2].strip()
    if not written:
        return _finite(number, unit)
    if unit == "K" and written in ("degC", "degF"):
        written = f"delta_{written}"
    try:
        return _finite(float(registry().Quantity(number, written).to(unit or "dimensionless").magnitude), unit)
    except pint.DimensionalityError as error:
        raise UnitError("wrong kind of unit", value=repr(text), next_step=_advice(unit)) from error
    except Exception as error:  # pint raises tokenizer, attribute and zero-division errors for unreadable unit text
        raise UnitError("unknown unit", value=repr(text), next_step=_advice(unit)) from error


def from_si(value: float, unit: str, wanted: str) -> float:
    """A value in `unit` expressed in `wanted`; UnitError when the dimensions differ."""
    try:
        return float(registry().Quantity(value, unit or "dimensionless").to(wanted).magnitude)
    except pint.PintError as error:
        raise UnitError("cannot be expressed in this unit", value=f"{value:g} {unit}", unit=wanted) from error


def written_unit(text: object) -> str:
    """The unit in what a user wrote: "2000 psi" → "psi"; empty for a bare number."""
    match = _NUMBER_AND_UNIT.match(text) if isinstance(text, str) else None
    return match[2].strip() if match else ""


def _finite(value: float, unit: str) -> float:
    if math.isfinite(value):
        return value
    raise UnitError("a finite number was expected", value=value, unit=unit)


def _advice(unit: str) -> str:
    return f"Write it in {unit} or a unit convertible to it, for example '1.5 {unit}'." if unit else "Write a number without a unit."
