"""Results in the units in which the rig file states its numbers; findings.json and whatever is computed stays in SI.

A constant has the unit it is written in. What belongs to a joint or a sensor has that of its travel or range (`mm`, and `mm/s` for a
speed). Anything else has the unit of its kind that the file uses most, and SI where it uses none.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from config.errors import UnitError
from config.loading.stated_units import conversion, stated_units
from config.parsing.yaml_tree import parse
from config.readable import number
from config.stated_sentences import Conversion, StatedSentences
from config.unit_factors import FACTORS
from config.units import from_si, written_unit

_UNIT = re.compile(r"[A-Za-z][\w*/^]*$")  # no date, no sentence that begins with a number
_NEVER = ("", "K", "degC")  # no unit to choose, or one that has an offset where a difference may be meant
_IN_SENTENCES = tuple(unit for unit in FACTORS if unit not in (*_NEVER, "s", "Hz"))  # times of a log stay in its seconds


@dataclass(frozen=True, slots=True)
class Shown:
    """A unit and the way there from SI: shown = factor × SI + offset."""

    unit: str
    factor: float = 1.0
    offset: float = 0.0

    def of(self, value: Any) -> Any:
        """A number or an array."""
        return self.factor * value + self.offset

    def text(self, value: float | None) -> str:
        """With the unit, three to four digits."""
        return "no value" if value is None else f"{number(float(self.of(value)))} {self.unit}".strip()

    def span(self, ends: tuple[float, float] | list[float]) -> str:
        """`68.1 to 81`."""
        return f"{number(float(self.of(ends[0])))} to {number(float(self.of(ends[1])))}"


class FileUnits:
    """The units of one rig file's text. `si`: those of the SI after all."""

    def __init__(self, text: str, si: bool = False) -> None:
        self._si = si
        self._plain = parse(text, "rig.yaml").plain
        self._of_places = stated_units(text)
        self._used = Counter(unit for _, unit in _stated(self._plain))

    def constant(self, key: str, unit: str) -> Shown:
        """`plant.joints.axis.mass`, as findings.json has it."""
        stated = written_unit(_value(self._plain, key.split(".")))
        return (self._to(unit, stated) if stated else None) or self.other(unit)

    def channel(self, name: str, unit: str) -> Shown:
        """A sensor's reading, or what belongs to a joint: `axis.position`, `axis.velocity`, `sensor:axis.position`, `axis`."""
        place = name.removeprefix("sensor:")
        stated = self._of_places.get(place) or self._of_places.get(place.split(".")[0], "")
        return (self._to(unit, stated) if stated else None) or self.other(unit)

    def other(self, unit: str) -> Shown:
        """By the kind of the number alone."""
        if unit not in _NEVER:
            for stated, _ in self._used.most_common():
                if (found := self._to(unit, stated, rates=False)) is not None:
                    return found
        return Shown(unit)

    @cached_property
    def sentences(self) -> StatedSentences:
        """For texts: a number has the unit of the constant, joint or signal that is named last before it, else the one of its kind."""
        stated = self._of_places | {f"plant.{key}": unit for key, unit in _stated(self._plain.get("plant", {}))}
        by_owner = {name: self._conversions(unit) for name, unit in stated.items()}
        anyone = {unit: (shown.unit, shown.factor, shown.offset) for unit in _IN_SENTENCES if (shown := self.other(unit)).unit != unit}
        return StatedSentences({} if self._si else {name: units for name, units in by_owner.items() if units}, {} if self._si else anyone)

    def _conversions(self, stated: str) -> dict[str, Conversion]:
        found = ((unit, self._to(unit, stated)) for unit in _IN_SENTENCES)
        return {unit: (shown.unit, shown.factor, shown.offset) for unit, shown in found if shown}

    def _to(self, unit: str, stated: str, rates: bool = True) -> Shown | None:
        if self._si or unit in _NEVER[:2]:
            return None
        if rates and (found := conversion(unit, stated)):
            return Shown(*found)
        try:
            return Shown(stated, from_si(1.0, unit, stated) - from_si(0.0, unit, stated), from_si(0.0, unit, stated))
        except UnitError:
            return None


def _stated(node: Any, key: str = "") -> Iterator[tuple[str, str]]:
    """Key with dots and unit of every number that is written with one."""
    if isinstance(node, (dict, list)):
        for name, value in node.items() if isinstance(node, dict) else enumerate(node):
            yield from _stated(value, f"{key}.{name}" if key else str(name))
    elif _UNIT.match(unit := written_unit(node)):
        yield key, unit


def _value(node: Any, words: list[str]) -> Any:
    """The value at a dotted key; names of sensors hold dots themselves. None where the file does not have it."""
    if not words:
        return node
    if isinstance(node, list):
        return _value(node[int(words[0])], words[1:]) if words[0].isdigit() and int(words[0]) < len(node) else None
    if not isinstance(node, dict):
        return None
    return next((_value(node[name], words[n:]) for n in range(len(words), 0, -1) if (name := ".".join(words[:n])) in node), None)
