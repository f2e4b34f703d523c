"""How often names were right in the blind test, for an effect at about a size. Nothing is made up where nothing was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import log
from pathlib import Path

from config.loading.load import read_text
from config.parsing.yaml_tree import parse

RECORD = Path(__file__).with_name("naming_record.yaml")  # written by `make blind`


@dataclass(frozen=True, slots=True)
class Tally:
    """Blind cases of one effect at one size (in smallest visible ones) and in how many the name was right or in the set."""

    effect: str
    multiple: float
    right: int
    cases: int


@lru_cache(maxsize=4)
def tallies(path: Path = RECORD) -> tuple[Tally, ...]:
    """All of the record; none where there is no record."""
    if not path.exists():
        return ()
    rows = parse(read_text(path), str(path)).plain["cases"]
    return tuple(Tally(str(row["effect"]), float(row["multiple"]), int(row["right"]), int(row["cases"])) for row in rows)


def named_of(multiple: float, effect: str = "", record: Sequence[Tally] | None = None) -> str:
    """`5 of 6` of the blind cases of that size, of one effect or of all; empty where there were none."""
    known = tallies() if record is None else record
    asked = [tally for tally in known if tally.multiple == multiple and effect in ("", tally.effect)]
    return f"{sum(t.right for t in asked)} of {sum(t.cases for t in asked)}" if asked else ""


def how_often_right(effect: str, multiple: float | None, record: Sequence[Tally] | None = None) -> str:
    """A sentence for the report: the tally of the nearest size, and that of all effects at that size beside it."""
    known = tallies() if record is None else record
    if not known:
        return "There is no blind-test record with this version (`make blind` writes one)."
    sizes = sorted({tally.multiple for tally in known if tally.multiple > 0})
    if multiple is None or multiple <= 0 or not sizes:
        return "The blind test has no sizes for this effect."
    nearest = min(sizes, key=lambda size: abs(log(size / multiple)))
    own = named_of(nearest, effect, known)
    all_cases = f"all effects of that size: {named_of(nearest, record=known)}"
    size = f"about {multiple:.3g} times the smallest visible size"
    if not own:
        return f"Not among the blind cases; this one is {size} (the nearest there: {nearest:g} times; {all_cases})."
    named = f"{effect} at {nearest:g} times the smallest visible size was named right in {own} cases"
    return f"In the blind test, {named} ({all_cases}); this one is {size}."
