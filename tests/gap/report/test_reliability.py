"""What a report says of how often such names were right hangs on where the name stands."""

from __future__ import annotations

import pytest

from gap.report.reliability import FURTHER, LEAD, RIGHT_OF, SUREST, how_often_right, places


@pytest.mark.parametrize(
    ("verdict", "probabilities", "expected"),
    [
        ("named", [0.9], [SUREST]),
        ("ambiguous", [0.7, 0.99], [FURTHER, SUREST]),
        ("named", [1.0, 1.0, 0.6], [SUREST, FURTHER, FURTHER]),  # one alone is the surest
        ("unknown", [0.9, 0.8], [LEAD, LEAD]),
        ("no_gap", [], []),
    ],
)
def test_a_name_stands_alone_or_beside_something(verdict: str, probabilities: list[float], expected: list[str]) -> None:
    assert places(verdict, probabilities) == expected


@pytest.mark.parametrize("place", [SUREST, FURTHER, LEAD])
def test_the_counts_of_its_place_and_its_range_are_told(place: str) -> None:
    for probability, least, words in ((0.995, 0.99, "0.99 and more"), (0.6, 0.5, "less than 0.99")):
        right, said = RIGHT_OF[place][least]
        assert (
            how_often_right(probability, place)
            == f"In the blind study {right} of {said} were right that were {place} and said with {words}."
        )
    assert how_often_right(0.3, place) == ""
