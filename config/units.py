"""The one place where units are converted: what a user writes ("2000 psi") becomes a float in SI (temperatures in degC).

The factors stand in a table written by pint (`unit_factors`); a unit outside it is asked of pint itself (`pint_units`), which takes 0.4 s.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from functools import cache, lru_cache

from config.errors import UnitError
from config.unit_factors import FACTORS, TEMPERATURES

_NUMBER_AND_UNIT = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)$")

UNKNOWN = "unknown unit"
_AFTER_COMMA = re.compile(r",\d")


@lru_cache(maxsize=4096, typed=True)
def to_si(text: str | float, unit: str) -> float:
    """Convert what the user wrote to `unit`; a bare number is taken to be in `unit` already.

    `unit` is a pint expression such as "Pa", "m", "V/rad", "degC" or "" (dimensionless). "K" is a temperature difference
    (temperatures themselves are kept in degC), so "0.1 degC" and "0.18 degF" are both 0.1 K.
    Raises UnitError with the value and the wanted unit when the text is not a quantity or the dimensions differ. Its mend never puts the
    number into another unit (0.3 V/psi is not 0.3 V/rad) and invents none.
    """
    if isinstance(text, bool):
        raise UnitError("a number was expected", value=text, unit=unit)
    if isinstance(text, (int, float)):
        return _finite(float(text), unit)
    match = _NUMBER_AND_UNIT.match(text)
    if not match:
        raise UnitError("not a number with a unit", value=repr(text), next_step=_advice(unit))
    number, written = float(match[1]), match[2].strip()
    if _AFTER_COMMA.match(written):
        raise UnitError("a decimal comma", value=repr(text), next_step="Write a point.", mend={text: text.replace(",", ".", 1)})
    if not written:
        return _finite(number, unit)
    try:
        return _finite(_from_written(number, written, unit), unit)
    except ValueError as error:
        raise UnitError("wrong kind of unit", value=repr(text), next_step=_advice(unit)) from error
    except LookupError as error:
        raise UnitError(UNKNOWN, value=repr(text), next_step=_advice(unit)) from error


def from_si(value: float, unit: str, wanted: str) -> float:
    """A value in `unit` expressed in `wanted`; UnitError when the dimensions differ."""
    try:
        if unit == "degC" and wanted in TEMPERATURES:
            return _temperature(value, unit, wanted)
        return value / factor if (factor := _factor(unit, wanted)) is not None else _of_pint(value, unit, wanted)
    except (ValueError, LookupError) as error:
        raise UnitError("cannot be expressed in this unit", value=f"{value:g} {unit}", unit=wanted) from error


def units_like(unit: str) -> Collection[str]:
    """What users of hydraulics write for a stored unit."""
    return TEMPERATURES if unit == "degC" else FACTORS.get(unit, {})


def is_stored(unit: str) -> bool:
    """Whether the project stores numbers in this unit (`Pa`): what is counted in days or cycles has no other unit to be shown in."""
    return unit in FACTORS


def _from_written(number: float, written: str, unit: str) -> float:
    """ValueError: of another dimension. LookupError: no unit."""
    if unit == "degC" and written in TEMPERATURES:
        return _temperature(number, written, unit)
    factor = _factor(unit, written)
    return number * factor if factor is not None else _of_pint(number, written, unit)


def _factor(unit: str, written: str) -> float | None:
    """Of a written unit to a stored one; None where the table does not know one of them. ValueError when the dimensions differ."""
    factor = FACTORS.get(unit, {}).get(written)
    if factor is None and unit in FACTORS and written in _listed():
        raise ValueError(f"{written} is of another dimension than {unit}")
    return factor


@cache
def _listed() -> frozenset[str]:
    """Every written unit of the table."""
    return frozenset({unit for units in FACTORS.values() for unit in units} | TEMPERATURES.keys())


def _temperature(value: float, unit: str, wanted: str) -> float:
    (scale, offset), (wanted_scale, wanted_offset) = TEMPERATURES[unit], TEMPERATURES[wanted]
    same = (scale, offset) == (wanted_scale, wanted_offset)
    return value if same else (value * scale + offset - wanted_offset) / wanted_scale


def _of_pint(value: float, unit: str, wanted: str) -> float:
    from config.pint_units import converted

    return converted(value, unit, wanted)


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
