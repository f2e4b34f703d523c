"""The recording in the same folder that ends where a log begins: a long arming is cut between runs, and armed follows standby."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from config.errors import LogError
from recording.files.reader import Log, read_log
from recording.files.recordings import recordings
from recording.files.scan import BAD_INDEX

JOIN_S = 1.0  # a recording that ended longer before is another one; the cycles decide


def with_preceding(log: Log, seconds: float) -> Log:
    """The log with the last `seconds` of the recording that it continues, and that one's requests and events; the log alone where there is
    none. A run that was under way then is there from its beginning. For looking only: it cannot be executed again, since its controller
    state is that of its second part."""
    before = preceding(log)
    if before is None:
        return log
    rows = slice(_at_rest(before, float(log.columns["t_s"][0]) - seconds), None)
    first_t_s = float(before.columns["t_s"][rows][0])
    return Log(
        path=log.path,
        layout=log.layout,
        columns={name: np.concatenate([before.columns[name][rows], values]) for name, values in log.columns.items()},
        time_ns=np.concatenate([before.time_ns[rows], log.time_ns]),
        events=[event for event in before.events if event.t_s >= first_t_s] + log.events,
        attachments=before.attachments | log.attachments,
        metadata=log.metadata,
        complete=log.complete,
        cut_text=log.cut_text,
        damage=log.damage,
        topics=log.topics,
        set_points=[stamped for stamped in before.set_points if stamped.t_s >= first_t_s] + log.set_points,
    )


def _at_rest(log: Log, t_s: float) -> int:
    """The last row up to a moment in which no run was moving the arm; the row of that moment where there is none."""
    row = min(int(np.searchsorted(log.columns["t_s"], t_s)), log.cycles - 1)
    at_rest = np.flatnonzero(log.columns["segment"][: row + 1] == 0)
    return int(at_rest[-1]) if len(at_rest) else row


def preceding(log: Log) -> Log | None:
    """The recording that a log continues, cycle by cycle; None where none stands beside it."""
    if not log.cycles:
        return None
    for path in recordings(log.path.parent):
        if path == log.path or not 0 < int(log.time_ns[0]) - _end_ns(path) < JOIN_S * 1e9:
            continue
        try:
            other = read_log(path)
        except LogError:
            continue
        same = other.layout.schema_text == log.layout.schema_text
        if same and other.cycles and int(other.columns["cycle"][-1]) + 1 == int(log.columns["cycle"][0]):
            return other
    return None


def _end_ns(path: Path) -> int:
    """When the last message of a closed log was made, from its summary; 0 where it has none."""
    try:
        with path.open("rb") as file:
            summary = make_reader(file).get_summary()
    except BAD_INDEX:
        return 0
    return int(summary.statistics.message_end_time) if summary is not None and summary.statistics is not None else 0
