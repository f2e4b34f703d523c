"""What installed packages bring: entry points by name. `longreach.drivers` holds factories, `longreach.driver_options` their options."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points

DRIVERS = "longreach.drivers"
OPTIONS = "longreach.driver_options"


@cache
def installed(group: str) -> dict[str, EntryPoint]:
    """Name → entry point."""
    return {point.name: point for point in entry_points(group=group)}
