"""A span of time cut out of a log as a whole log of its own, that can be read, asked and executed again without the rest."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from config.errors import LongreachError
from config.whole_file import replaced_when_done
from recording.evaluation.replay import controller_state_before
from recording.files.copying import copy_records
from recording.files.preceding import preceding
from recording.files.reader import Log
from recording.files.scan import Attached, Entries, Message
from recording.files.writer import LogWriter
from recording.format.fields import FIRST_CYCLE

STATE = "controller_state.json"
_OF_THE_WHOLE = (STATE, "timing_passport.json")


def cut_out(log: Log, start_t_s: float, end_t_s: float, out: Path) -> bool:
    """From the cycle at `start_t_s` to that at `end_t_s` (column t_s), with the end of the recording that the log continues where it
    begins later. `out` appears when it is whole, and replaces what was there. False for a log whose controller cannot be executed again up
    to there: then the new one cannot be either.

    To know the controller's state at its beginning, everything before it is executed again.
    """
    before = preceding(log) if start_t_s < log.columns["t_s"][0] else None
    parts = [part for part in (before, log) if part is not None]
    spans = {part.path: _rows(part, start_t_s, end_t_s) for part in parts}
    runs = {int(n) for part in parts for n in np.unique(part.columns["maneuver"][spans[part.path]])}
    state = _state(parts[0], spans[parts[0].path].start)
    with replaced_when_done(out) as temporary:
        writer = LogWriter(temporary, log.layout, state, {"recording": _about(log, parts[0], spans)}, _stamp(parts[0], spans))
        for part in parts:
            _copy(part, spans[part.path], runs, part is log, writer)
        writer.close({"ended_by": f"cut out of {log.path.name}"})
    return bool(state)


def _rows(log: Log, start_t_s: float, end_t_s: float) -> slice:
    """Both ends are in it."""
    first, last = (int(np.argmin(np.abs(log.columns["t_s"] - moment))) for moment in (start_t_s, end_t_s))
    return slice(first, last + 1)


def _about(log: Log, first: Log, spans: Mapping[Path, slice]) -> dict[str, str]:
    """What the log says of itself, with the first cycle of the part."""
    return log.metadata["recording"] | {FIRST_CYCLE: str(first.columns["cycle"][spans[first.path].start])}


def _stamp(log: Log, spans: Mapping[Path, slice]) -> int:
    return int(log.time_ns[spans[log.path].start])


def _state(log: Log, row: int) -> dict[str, tuple[str, bytes]]:
    try:
        return {STATE: ("application/json", json.dumps(controller_state_before(log, row)).encode())}
    except LongreachError:
        return {}


def _copy(log: Log, rows: slice, runs: set[int], is_last: bool, writer: LogWriter) -> None:
    """Messages of the span and the requests of its runs; what every recording has comes from the last part alone."""
    first_ns, last_ns = int(log.time_ns[rows][0]), int(log.time_ns[rows][-1])
    requests = {f"{name}-{run}.{kind}" for run in runs for name, kind in (("run", "json"), ("maneuver", "yaml"))}

    def keep(content: Message | Attached | Entries) -> bool:
        if isinstance(content, Message):
            return first_ns <= content.log_time_ns <= last_ns
        if isinstance(content, Entries):
            return is_last and content.name not in ("recording", "closing")
        if content.name.startswith(("run-", "maneuver-")):
            return content.name in requests
        return is_last and content.name not in _OF_THE_WHOLE

    copy_records(log, writer, keep)
