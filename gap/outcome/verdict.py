"""The word of a search and why, in a sentence: no gap, wrong constants, named effects, look-alikes, or unknown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gap.data.coarse_steps import CoarseStep


@dataclass(frozen=True, slots=True)
class Verdict:
    """The word of the findings file and why, in a sentence. `confirmed`: all that is named."""

    word: str
    why: str
    confirmed: bool


def with_steps(word: Verdict, coarse: Sequence[CoarseStep]) -> Verdict:
    """The verdict of the search beside readings whose steps the data show by themselves: these are named however the rest ends."""
    if not coarse or word.word == "data_problem":
        return word
    said = "; ".join(item.text() for item in coarse)
    plain = word.word in ("no_gap", "parameter_mismatch")
    return Verdict("named" if plain else word.word, f"{said}. {word.why}", word.confirmed)
