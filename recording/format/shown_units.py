"""The numbers of a log or of a live sample as their rig file states them."""

from __future__ import annotations

from collections.abc import Mapping

from config.loading.stated_units import conversion
from config.stated_sentences import Conversion
from recording.format.fields import field_of_signal


def field_conversions(units: Mapping[str, str], stated: Mapping[str, str]) -> dict[str, Conversion]:
    """Field → unit, factor and offset: a signal's own as its range is stated, the others of a joint as its travel, their rates with them.

    `units`: field → SI unit; `stated`: as `stated_units` gives it. Fields that the rig file says nothing about are left out.
    """
    owners = {_field(name): name for name in stated}
    found = {}
    for field, unit in units.items():
        for owner in (owners.get(field, ""), field.partition(".")[0]):
            shown = conversion(unit, stated[owner]) if unit and owner in stated else None
            if shown is not None:
                found[field] = shown
                break
    return found


def _field(owner: str) -> str:
    """Of a signal; a joint has none of its own."""
    try:
        return field_of_signal(owner)
    except KeyError:
        return owner
