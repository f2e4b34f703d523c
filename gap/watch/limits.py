"""How far each number may go: what was asked for, else three prior standard deviations of its tag to either side."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from config.errors import UnitError, UsageError
from config.parsing.nearest import nearest_text
from config.units import to_si, written_unit
from gap.fitting.nuisance import ALARM
from gap.outcome.file_units import FileUnits
from gap.watch.watched import Watched


@dataclass(frozen=True, slots=True)
class NumberLimits:
    """SI; infinite where there is none."""

    low: float
    high: float


def limits_of(numbers: Sequence[Watched], asked: Sequence[str], units: FileUnits) -> dict[str, NumberLimits]:
    """By name. `asked`: NAME=VALUE each, a bare number in the unit of the rig file; above the stated value it is an upper limit, below a
    lower one, and the other side keeps its own. UsageError for a name that is not followed and for what cannot be a limit."""
    by_name = {number.name: number for number in numbers}
    stated: dict[tuple[str, str], float] = {}
    for one in asked:
        name, equals, text = one.rpartition("=")
        if name not in by_name or not equals:
            known = f"{nearest_text(name or one, by_name)}" or f": one of {', '.join(by_name)}"
            raise UsageError(f"no number of this name is followed{known}", value=one, where="--limit", next_step="Write NAME=VALUE.")
        value = _quantity(one, text, by_name[name], units)
        side = _side(one, value, by_name[name], units)
        if (name, side) in stated:
            raise UsageError(f"the {side} limit of {name} is given twice", value=one, where="--limit", next_step="Give one of them.")
        stated[name, side] = value
    return {name: _limits(number, stated) for name, number in by_name.items()}


def _side(one: str, value: float, number: Watched, units: FileUnits) -> str:
    start = number.free.start
    what = "a limit at the rig file's value is neither an upper nor a lower one" if value == start else ""
    if value * start < 0.0 and not number.wide.low <= value <= number.wide.high:  # a null bias may turn, a friction may not
        what = "the number never has the other sign, so this limits nothing"
    if what:
        stated = f"the rig file has {units.constant(number.free.key, number.free.unit).text(start)}"
        raise UsageError(what, value=one, limit=stated, where="--limit", next_step="Give an upper limit above that or a lower one below.")
    return "upper" if value > start else "lower"


def _limits(number: Watched, stated: Mapping[tuple[str, str], float]) -> NumberLimits:
    own = _own(number)
    return NumberLimits(stated.get((number.name, "lower"), own.low), stated.get((number.name, "upper"), own.high))


def _own(number: Watched) -> NumberLimits:
    """Of the rig file's prior; none on the other side of 0."""
    start, way = number.free.start, ALARM * number.free.scale
    low, high = start - way, start + way
    return NumberLimits(low if low * start > 0.0 else -math.inf, high if high * start > 0.0 else math.inf)


def _quantity(one: str, text: str, number: Watched, units: FileUnits) -> float:
    try:
        return _value(text, number, units)
    except UnitError as error:
        raise UsageError(error.refusal.what, value=one, where="--limit", next_step=error.refusal.next_step) from error


def _value(text: str, number: Watched, units: FileUnits) -> float:
    unit = number.free.unit
    if written_unit(text):
        return to_si(text, unit)
    shown = units.constant(number.free.key, unit)
    return (to_si(text, unit) - shown.offset) / shown.factor
