"""Dates and times of day as data loggers write them: `2026-11-25 20:57:12.5`, `25.11.2026 20:57:12,5`, `20:57:12.5`.

A column of them becomes seconds since its first row. Days with slashes are refused: whether 3/4 is in March or April no table says.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime

import numpy as np

from recording.importing.table import Floats

DAY_S = 86400.0
_CLOCK = r"(?P<hour>\d{1,2}):(?P<minute>\d\d)(?::(?P<second>\d\d)(?:[.,](?P<part>\d{1,9}))?)?"
_ZONE = r"(?P<zone>Z|[+-]\d\d:?\d\d)?"
_FORMS = tuple(
    re.compile(day + _CLOCK + _ZONE)
    for day in (r"(?P<year>\d{4})-(?P<month>\d\d)-(?P<day>\d\d)[T ]", r"(?P<day>\d{1,2})\.(?P<month>\d{1,2})\.(?P<year>\d{4})[T ]", "")
)


def seconds_of(cell: str) -> tuple[float, bool] | None:
    """Seconds since 1970, or since midnight, and whether the cell has a date; None where it is neither."""
    if ":" not in cell:  # numbers with a decimal comma are many
        return None
    found = next((match for form in _FORMS if (match := form.fullmatch(cell))), None)
    if found is None:
        return None
    parts = found.groupdict()
    hour, minute, second = (int(parts[name] or 0) for name in ("hour", "minute", "second"))
    year, month, day = (int(parts.get(name) or least) for name, least in (("year", 1970), ("month", 1), ("day", 1)))
    try:
        zone = datetime.strptime(parts["zone"], "%z").tzinfo if parts["zone"] else UTC
        moment = datetime(year, month, day, hour, minute, second, tzinfo=zone)
    except ValueError:  # there is no such day, or no such time
        return None
    return moment.timestamp() + float(f"0.{parts['part'] or 0}"), bool(parts.get("year"))


def since_first(seconds: Floats, dated: bool) -> Floats:
    """Seconds since the first row that has one; times of day go on over midnight."""
    there = np.isfinite(seconds)
    found = seconds.copy()
    if not dated:
        found[there] = np.unwrap(seconds[there], period=DAY_S)
    return np.asarray(found - found[there][0])
