"""Sentences whose numbers are SI, in the units of the rig file. Standard library alone.

A number belongs to the signal or joint that was named last before it ("rotary.supply_pressure", "the tip's acceleration"); without one, or
where that has no such unit, to the first joint or signal of the rig file that has.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from config.errors import ConfigError, LongreachError
from config.readable import number

Conversion = tuple[str, float, float]  # unit, factor and offset: shown = factor × SI + offset
ByUnit = Mapping[str, Conversion]  # SI unit → how the rig file states it
_NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
_QUANTITY = rf"(?<![\w.])({_NUMBER})(?:( to | ± )({_NUMBER}))? (UNITS)(?![\w/^*]| rms)(?: \([-+.\d]+°\))?"
_BETWEEN = r"(?:[._ ]|'s )"  # tip.acceleration, tip_acceleration_max, the tip's acceleration


class StatedSentences:
    """`by_owner`: signal or joint → SI unit → unit, factor and offset; the answer `sentences` to `units`, in the order of the rig file.
    `anyone`: for numbers without an owner, or with one that has no such unit; by default as the first that has one."""

    def __init__(self, by_owner: Mapping[str, ByUnit], anyone: ByUnit | None = None) -> None:
        self._by_owner = by_owner
        self._anyone = dict(anyone or {})
        for each in by_owner.values():
            self._anyone = {**each, **self._anyone}
        names = "|".join(re.escape(name).replace(r"\.", _BETWEEN) for name in sorted(by_owner, key=len, reverse=True))
        self._owners = {_letters(name): name for name in by_owner}
        units = "|".join(re.escape(unit) for unit in sorted(self._anyone, key=len, reverse=True))
        self._parts = re.compile(rf"\b(?P<owner>{names})(?![a-z0-9])|{_QUANTITY.replace('UNITS', units)}") if names and units else None

    def text(self, sentence: str) -> str:
        """The sentence with every quantity converted; what has no stated unit stays as it is. Four digits each, and up to seven where
        two that differ would read alike ("88.003 deg is above 88 deg")."""
        for digits in range(4, 8):
            source: dict[str, str] = {}
            shown = self._with_digits(sentence, digits, source)
            if len(set(source.values())) == len(source):
                break
        return shown

    def _with_digits(self, sentence: str, digits: int, source: dict[str, str]) -> str:
        """`source` takes up what every quantity was (key) and how it now reads."""
        owner = ""

        def part(found: re.Match[str]) -> str:
            nonlocal owner
            if found["owner"]:
                owner = self._owners[_letters(found["owner"])]
                return found[0]
            return source.setdefault(f"{owner} {found[0]}", self._quantity(found, owner, digits))

        return self._parts.sub(part, sentence) if self._parts else sentence

    def refusal(self, error: LongreachError) -> LongreachError:
        """The same refusal, put for who wrote the rig file. The problems of a file are in the units of that file already."""
        if isinstance(error, ConfigError):
            return error
        parts = error.refusal
        unit = f" {parts.unit}" if parts.unit else ""
        value, limit = (f"{each}{unit}" if each else "" for each in (parts.value, parts.limit))
        what, value, limit = self.text(f"{parts.what}\0{value}\0{limit}").split("\0")
        mend = {key: value and self.text(value) for key, value in parts.mend.items()}
        return type(error)(what, value=value, limit=limit, where=parts.where, next_step=self.text(parts.next_step), mend=mend)

    def _quantity(self, found: re.Match[str], owner: str, digits: int) -> str:
        first, between, last, si = found[2], found[3], found[4], found[5]
        unit, factor, offset = self._by_owner.get(owner, {}).get(si) or self._anyone[si]
        if unit == si:
            return found[0]
        shown = number(factor * float(first) + offset, digits)
        if last:  # what stands behind ± is a difference
            shown += between + number(factor * float(last) + (offset if between == " to " else 0.0), digits)
        return f"{shown} {unit}"


def _letters(name: str) -> str:
    return re.sub(r"'s |[^a-z0-9]", "", name)


def sentences_from(answer: Mapping[str, Any]) -> StatedSentences:
    """From the daemon's answer to `units`; a daemon of before this gives none."""
    by_owner = answer.get("sentences", {})
    return StatedSentences({owner: {si: (u, f, o) for si, (u, f, o) in units.items()} for owner, units in by_owner.items()})
