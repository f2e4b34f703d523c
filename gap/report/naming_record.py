"""How often names were right in the blind test, for an effect at about a size. Nothing is made up where nothing was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import log
from pathlib import Path

from config.load import read_text
from config.yaml_tree import parse

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


def how_often_right(effect: str, multiple: float | None, record: Sequence[Tally] | None = None) -> str:
    """A sentence for the report: the tally of the nearest size, and that of all effects at that size beside it."""
    known = tallies() if record is None else record
    if not known:
        return "There is no blind-test record with this version (`make blind` writes one)."
    sizes = sorted({tally.multiple for tally in known if tally.multiple > 0})
    if multiple is None or multiple <= 0 or not sizes:
        return "The blind test has no sizes for this effect."
    nearest = min(sizes, key=lambda size: abs(log(size / multiple)))
    every = [tally for tally in known if tally.multiple == nearest]
    own = [tally for tally in every if tally.effect == effect]
    all_cases = f"all effects of that size: {sum(t.right for t in every)} of {sum(t.cases for t in every)}"
    size = f"about {multiple:.3g} times the smallest visible size"
    if not own:
        return f"Not among the blind cases; this one is {size} (the nearest there: {nearest:g} times; {all_cases})."
    right, cases = sum(t.right for t in own), sum(t.cases for t in own)
    named = f"{effect} at {nearest:g} times the smallest visible size was named right in {right} of {cases} cases"
    return f"In the blind test, {named} ({all_cases}); this one is {size}."
