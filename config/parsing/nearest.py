"""The name a user probably meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, known: Iterable[str], alike: float = 0.5) -> str | None:
    """The known name most like `name`, or None when nothing is as much alike (0 to 1: the share of letters in common)."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    matches = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=alike)
    return by_lower[matches[0]] if matches else None


def nearest_text(name: str, known: Iterable[str]) -> str:
    """ ": nearest is 'gain'" for the end of a sentence, or nothing."""
    found = nearest(name, known)
    return f": nearest is {found!r}" if found else ""
