"""Dates and times of day as data loggers write them: `2026-11-25 20:57:12.5`, `25.11.2026 20:57:12,5`, `20:57:12.5`.

A column of them becomes seconds since its first row. Days with slashes are refused: whether 3/4 is in March or April no table says.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DAY_S = 86400.0
_CLOCK = r"(?P<hour>\d{1,2}):(?P<minute>\d\d)(?::(?P<second>\d\d)(?:[.,](?P<part>\d{1,9}))?)?"
_ZONE = r"(?P<zone>Z|[+-]\d\d:?\d\d)?"
_FORMS = tuple(
    re.compile(day + _CLOCK + _ZONE)
    for day in (r"(?P<year>\d{4})-(?P<month>\d\d)-(?P<day>\d\d)[T ]", r"(?P<day>\d{1,2})\.(?P<month>\d{1,2})\.(?P<year>\d{4})[T ]", "")
)


def seconds_of(cell: str) -> tuple[float, bool] | None:
    """Seconds since 1970, or since midnight, and whether the cell has a date; None where it is neither."""
    found = next((match for form in _FORMS if (match := form.fullmatch(cell))), None)
    if found is None:
        return None
    parts = found.groupdict()
    hour, minute, second = (int(parts[name] or 0) for name in ("hour", "minute", "second"))
    year, month, day = (int(parts.get(name) or least) for name, least in (("year", 1970), ("month", 1), ("day", 1)))
    try:
        moment = datetime(year, month, day, hour, minute, second, tzinfo=_zone(parts["zone"]))
    except ValueError:  # there is no such day, or no such time
        return None
    return moment.timestamp() + float(f"0.{parts['part'] or 0}"), bool(parts.get("year"))


def since_first(seconds: Array, dated: bool) -> Array:
    """Seconds since the first row that has one; times of day go on over midnight."""
    there = np.isfinite(seconds)
    found = seconds.copy()
    if not dated:
        found[there] = np.unwrap(seconds[there], period=DAY_S)
    return np.asarray(found - found[there][0])


def _zone(text: str | None) -> timezone:
    if text in (None, "Z"):
        return UTC
    assert text is not None
    hours, minutes = int(text[1:3]), int(text[-2:])
    return timezone((1 if text[0] == "+" else -1) * timedelta(hours=hours, minutes=minutes))
