"""The name a user probably meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(name: str, known: Iterable[str]) -> str | None:
    """The known name most like `name`, or None when nothing is alike."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    matches = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.5)
    return by_lower[matches[0]] if matches else None


def nearest_text(name: str, known: Iterable[str]) -> str:
    """ ": nearest is 'gain'" for the end of a sentence, or nothing."""
    found = nearest(name, known)
    return f": nearest is {found!r}" if found else ""
