"""Values of the daemon, which are SI, in the units in which the rig file states them (the answer to `units`). Standard library alone."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from config.readable import number
from config.stated_sentences import Conversion

Units = Mapping[str, Conversion]
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def units_from(answer: Mapping[str, Any]) -> Units:
    """By check or joint."""
    return {name: (unit, factor, offset) for name, (unit, factor, offset) in answer["units"].items()}


def as_stated(check: dict[str, Any], units: Units) -> dict[str, Any]:
    """A check with its value and the numbers of its limit in the stated unit."""
    if check["name"] not in units:
        return check
    unit, factor, offset = units[check["name"]]
    value = check["value"]
    limit = _NUMBER.sub(lambda found: number(factor * float(found[0]) + offset), check["limit"])
    return {**check, "unit": unit, "limit": limit, "value": None if value is None else factor * value + offset}
