"""Which runs a sweep asks for: `servo.rotary.gain=0.2..0.5 V/deg:7` or `shaper=none,zvd`; several sweeps make a grid."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import product

import numpy as np

from config.errors import UsageError

MOST_RUNS = 10_000
SHAPER = "shaper"
OF_MANEUVER = "maneuver."
_SPAN = re.compile(  # "30..40 in:5"; the unit may stand twice
    r"^(?P<low>[-+.\deE]+)\s*(?P<first>[^:]*?)\s*\.\.\s*(?P<high>[-+.\deE]+)\s*(?P<unit>[^:]*?)\s*:\s*(?P<count>\d+)$"
)
Case = dict[str, str]  # key → value as a user writes it


def cases(sweeps: Sequence[str]) -> list[Case]:
    """Every combination, the last sweep changing fastest; without sweeps one case that changes nothing.

    UsageError for a sweep that cannot be read, or too many runs."""
    axes = [_values(sweep) for sweep in sweeps]
    count = int(np.prod([len(values) for _, values in axes], dtype=np.int64))
    if count > MOST_RUNS:
        raise UsageError("too many runs", value=count, limit=MOST_RUNS, where="--sweep", next_step="Sweep fewer values.")
    keys = [key for key, _ in axes]
    return [dict(zip(keys, chosen, strict=True)) for chosen in product(*(values for _, values in axes))]


def assignment(text: str) -> tuple[str, str]:
    """Key and value of `KEY=VALUE`; UsageError for anything else."""
    key, equals, value = (part.strip() for part in text.partition("="))
    if not key or not equals or not value:
        advice = "Write KEY=VALUE, e.g. maneuver.y0='30 in'."
        raise UsageError("this setting cannot be read", value=repr(text), where="--set", next_step=advice)
    return key, value


def _values(sweep: str) -> tuple[str, list[str]]:
    key, equals, text = (part.strip() for part in sweep.partition("="))
    if not key or not equals or not text:
        raise _unreadable(sweep)
    span = _SPAN.match(text)
    if span is None:
        if ".." in text:
            raise _unreadable(sweep)
        return key, [value.strip() for value in text.split(",") if value.strip()]
    try:
        low, high, count = float(span["low"]), float(span["high"]), int(span["count"])
    except ValueError:
        raise _unreadable(sweep) from None
    if count < 1 or span["first"] not in ("", span["unit"]):
        raise _unreadable(sweep)
    return key, [f"{value:.9g} {span['unit']}".strip() for value in np.linspace(low, high, count)]


def _unreadable(sweep: str) -> UsageError:
    advice = (
        "Write KEY=FROM..TO UNIT:COUNT or KEY=A,B,C, e.g. servo.rotary.gain='0.2..0.5 V/deg:7', shaper=none,zvd, maneuver.y0='30 in,40 in'."
    )
    return UsageError("this sweep cannot be read", value=repr(sweep), where="--sweep", next_step=advice)
