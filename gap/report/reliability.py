"""How often the names of a report are right, as the blind study counted it (docs/results/blind.md; a test holds these to its results)."""

from __future__ import annotations

from collections.abc import Sequence

SUREST, FURTHER, LEAD = "the surest name of a log", "a name beside a surer one", "a lead under unknown"
RIGHT_OF = {  # from a probability on, up to the next: names that were right, of so many
    SUREST: {0.99: (206, 208), 0.5: (14, 23)},
    FURTHER: {0.99: (26, 28), 0.5: (1, 17)},
    LEAD: {0.99: (23, 32), 0.5: (1, 19)},
}


def places(verdict: str, probabilities: Sequence[float]) -> list[str]:
    """Where each name of a log stands; of equally sure ones the first is the surest. Under `unknown` nothing is named: what helped is a
    lead."""
    if verdict == "unknown":
        return [LEAD] * len(probabilities)
    numbers = range(len(probabilities))
    first = max(numbers, key=lambda n: probabilities[n], default=0)
    return [SUREST if n == first else FURTHER for n in numbers]


def how_often_right(probability: float, place: str) -> str:
    """In words; empty below what the study has counted."""
    least = next((edge for edge in RIGHT_OF[place] if probability >= edge), None)
    if least is None:
        return ""
    right, said = RIGHT_OF[place][least]
    how_sure = "0.99 and more" if least == 0.99 else "less than 0.99"
    return f"In the blind study {right} of {said} were right that were {place} and said with {how_sure}."
