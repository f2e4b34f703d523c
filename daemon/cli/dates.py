"""Dates as options take them, UTC: 2026-05-31, 2026-05-31T14:00."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from config.errors import UsageError


def moment(text: str | None, option: str, end: bool = False) -> datetime | None:
    """None where none was given; `end`: a bare date means all of that day. UsageError for what is no date."""
    if text is None:
        return None
    try:
        found = datetime.fromisoformat(text)
    except ValueError as error:
        advice = "Write it as 2026-05-31 or 2026-05-31T14:00."
        raise UsageError("no date", value=repr(text), where=option, next_step=advice, mend={option: "2026-05-31"}) from error
    found = found if found.tzinfo else found.replace(tzinfo=UTC)
    return found + timedelta(days=1) if end and len(text) == len("2026-05-31") else found
