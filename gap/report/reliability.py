"""How often the names of a report are right, as the blind study counted it (docs/results/blind.md; a test holds these to its results)."""

from __future__ import annotations

RIGHT_OF = {0.99: (255, 268), 0.5: (16, 59)}  # from a probability on, up to the next: names that were right, of so many


def how_often_right(probability: float) -> str:
    """In words; empty below what the study has counted."""
    least = next((edge for edge in RIGHT_OF if probability >= edge), None)
    if least is None:
        return ""
    right, said = RIGHT_OF[least]
    return f"Of names said with {'0.99 and more' if least == 0.99 else 'less than 0.99'} {right} of {said} were right in the blind study."
