"""Numbers as options take them: finite, and within what has a meaning; the refusal names the nearest that fits.

Python reads "nan", which no comparison refuses: it went on as far as a matrix, a clock or a countdown.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from math import inf, isfinite
from typing import TypeVar

LONGEST_PAUSE_S = 3600.0


def finite(low: float = -inf, high: float = inf, unit: str = "") -> Callable[[str], float]:
    """An argparse type: a finite number from `low` to `high`."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = inf
        if not isfinite(value):
            raise argparse.ArgumentTypeError(f"{text!r} is no number")
        return _within(value, low, high, text, unit)

    return read


def pause_s(text: str) -> float:
    """An argparse type: a time of 0 or more, with its unit. UnitError for another unit."""
    from config.units import to_si

    return _within(to_si(text, "s"), 0.0, LONGEST_PAUSE_S, text, "s")


def several(each: Callable[[str], float]) -> Callable[[str], list[float]]:
    """An argparse type: such numbers with commas between."""
    return lambda text: [each(part.strip()) for part in text.split(",")]


def whole(low: int, high: int | None = None) -> Callable[[str], int]:
    """An argparse type: a whole number from `low` to `high`."""

    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is no whole number") from None
        return _within(value, low, inf if high is None else high, text, "")

    return read


COUNT = whole(1)  # of things, or which of them
SEED = whole(0)
PORT = whole(0, 65535)

_Number = TypeVar("_Number", int, float)


def _within(value: _Number, low: float, high: float, text: str, unit: str) -> _Number:
    if low <= value <= high:
        return value
    limit = f"{low:g} to {high:g}" if high < inf else f"at least {low:g}"
    near = low if value < low else high
    raise argparse.ArgumentTypeError(f"{text!r} is out of range (limit: {limit} {unit}".rstrip() + f"): nearest is {near:g}")
