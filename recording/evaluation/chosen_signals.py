"""Columns of a log picked by pattern, within a span of time, in the units of its own rig file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
import numpy.typing as npt

from config.errors import UsageError
from config.loading.stated_units import stated_units
from config.parsing.nearest import nearest, nearest_text
from config.stated_sentences import Conversion
from recording.files.reader import Log
from recording.files.recordings import asked
from recording.format.shown_units import field_conversions

DEVICE_ENDINGS = ("_raw", "_age_s")  # what a device gave and when: shown where a pattern asks for it by its ending

Floats = npt.NDArray[np.float64]
Span = tuple[float, float]
WHOLE: Span = (float("-inf"), float("inf"))


@dataclass(frozen=True, slots=True)
class ChosenSignal:
    """`values` over `t_s`, in `unit`."""

    name: str
    unit: str
    t_s: Floats
    values: Floats


def chosen_signals(log: Log, patterns: Sequence[str], span: Span = WHOLE, si: bool = False) -> list[ChosenSignal]:
    """Every column with numbers that one of the globs matches (`rotary.*`, `*.command_V`), in the log's order.

    UsageError for a pattern that matches no column, with the nearest name, and for a span without cycles.
    """
    rows = rows_of(log, span)
    names = [name for name in log.columns if any(_matches(name, pattern) for pattern in patterns)]
    for pattern in patterns:
        if not any(_matches(name, pattern) for name in log.columns):
            known = ", ".join(name for name in log.columns if not name.endswith(DEVICE_ENDINGS))
            advice = f"The log has: {known}; {asked('info', log.path)} shows which hold numbers."
            what = f"no signal of the log matches {pattern!r}{nearest_text(pattern, log.columns)}"
            better = nearest(pattern, log.columns)
            raise UsageError(what, where=str(log.path), next_step=advice, mend={pattern: better} if better else {})
    units = {} if si else column_conversions(log)
    chosen = [in_unit(log, name, rows, units) for name in names if name != "t_s"]
    return [signal for signal in chosen if np.any(np.isfinite(signal.values))]


def rows_of(log: Log, span: Span) -> slice:
    """The cycles with span[0] <= t_s <= span[1]."""
    t = log.columns["t_s"]
    first, last = (int(np.searchsorted(t, span[0], side="left")), int(np.searchsorted(t, span[1], side="right")))
    if last <= first:
        limit = f"{t[0]:.3f} to {t[-1]:.3f} s" if len(t) else "no cycle"
        value, mend = f"{span[0]:g} to {span[1]:g} s", {"--from": None, "--to": None}
        raise UsageError("the log has no cycle in this span", value=value, limit=limit, where=str(log.path), mend=mend)
    return slice(first, last)


def column_conversions(log: Log) -> dict[str, Conversion]:
    """Column → unit, factor and offset by which the log's rig file shows it; columns it shows in SI are left out."""
    text = log.attachments.get("rig.yaml", b"").decode()
    if not text:
        return {}
    return field_conversions({field.name: field.unit for field in log.layout.fields}, stated_units(text))


def in_unit(log: Log, name: str, rows: slice, units: Mapping[str, Conversion]) -> ChosenSignal:
    """One column in the unit that `units` names for it, else in SI."""
    plain = next(field.unit for field in log.layout.fields if field.name == name)
    unit, factor, offset = units.get(name, (plain, 1.0, 0.0))
    values = factor * np.asarray(log.columns[name][rows], dtype=np.float64) + offset
    return ChosenSignal(name, unit, np.asarray(log.columns["t_s"][rows], dtype=np.float64), values)


def _matches(name: str, pattern: str) -> bool:
    ending = next((ending for ending in DEVICE_ENDINGS if name.endswith(ending)), "")
    return fnmatchcase(name, pattern) and (not ending or pattern.endswith(ending) or name == pattern)
