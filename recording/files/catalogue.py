"""Which runs a folder of logs holds, from the end of each file: its index, metadata, requests and events, not its cycles.

A log that was cut has no index and one of another system no events: these are read whole.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import McapReader, make_reader

from recording.files.info import ENDED_BEFORE, RunFacts, run_facts, why_invalid
from recording.files.reader import log_bytes, read_log
from recording.files.recordings import recordings
from recording.files.scan import BAD_INDEX
from recording.files.writer import CYCLE_TOPIC, EVENT_TOPIC
from recording.format.event import Event, decode_event


@dataclass(frozen=True, slots=True)
class Recorded:
    """One log. `begun`: when each run began to move, in UTC, by its number; `faults`: how many it holds. `recovered`: it is what was left
    of a log that was cut or damaged, so cycles of a valid run may be missing."""

    path: Path
    rig_name: str
    ended_by: str
    complete: bool
    recovered: bool
    runs: tuple[RunFacts, ...]
    begun: dict[int, datetime]
    faults: int


def logs_in(places: Iterable[Path]) -> list[Path]:
    """Every recording in these folders, by name, and the files themselves that are named. LogError for a place that cannot be read."""
    found: list[Path] = []
    for place in places:
        found += [place] if os.path.isfile(place) else recordings(place)
    return list(dict.fromkeys(found))


def recorded(path: Path) -> Recorded:
    """What one log holds. LogError where it is none of ours or cannot be read."""
    log_bytes(path)  # LogError for what is no MCAP file
    try:
        with path.open("rb") as file:
            reader = make_reader(file)
            if reader.get_summary() is not None:
                return _from_end(path, reader)
    except BAD_INDEX:
        pass  # no index that can be trusted: read it whole
    return _from_rows(path)


def _from_end(path: Path, reader: McapReader) -> Recorded:
    metadata = {entry.name: entry.metadata for entry in reader.iter_metadata()}
    closing = metadata.get("closing", {})
    if metadata.get("recording", {}).get("kind") == "imported":
        return _from_rows(path)
    stamped = [(message.log_time, decode_event(message.data)) for _, _, message in reader.iter_messages(topics=[EVENT_TOPIC])]
    events = [event for _, event in stamped]
    requests = {entry.name: json.loads(entry.data) for entry in reader.iter_attachments() if entry.name.startswith("run-")}
    if requests and not any(event.name == "run_started" for event in events):
        return _from_rows(path)  # requests of runs that never began, or a log without events
    starts = {int(event.values["run"]): stamp_ns for stamp_ns, event in stamped if event.name == "run_started"}
    begun = {number: _utc(stamp_ns) for number, stamp_ns in starts.items()}
    open_s = {number: 1e-9 * (_last_cycle_ns(reader) - stamp_ns) for number, stamp_ns in starts.items() if number not in _ended(events)}
    complete, runs = closing.get("complete") == "true", tuple(_runs(events, requests, open_s))
    return _recorded(path, metadata, complete, runs, begun, events)


def _last_cycle_ns(reader: McapReader) -> int:
    """Only the end of the file is read."""
    return next((message.log_time for _, _, message in reader.iter_messages(topics=[CYCLE_TOPIC], reverse=True)), 0)


def _ended(events: list[Event]) -> dict[int, Event]:
    return {int(event.values["run"]): event for event in events if event.name == "run_ended"}


def _runs(events: list[Event], requests: dict[str, Any], open_s: dict[int, float]) -> Iterator[RunFacts]:
    """`open_s`: how much there is of runs that did not end in this log."""
    ended = _ended(events)
    for start in (event for event in events if event.name == "run_started"):
        number = int(start.values["run"])
        request, end = requests.get(f"run-{number}.json", {}), ended.get(number)
        reason = ENDED_BEFORE if end is None else why_invalid(end)
        yield RunFacts(
            number=number,
            maneuver=request.get("maneuver", {}).get("name", "unknown"),
            shaper=request.get("shaper", {}).get("kind", "unknown"),
            start_t_s=start.t_s,
            duration_s=open_s[number] if end is None else end.t_s - start.t_s,
            valid=not reason,
            reason=reason,
        )


def _from_rows(path: Path) -> Recorded:
    log = read_log(path)
    runs = tuple(run_facts(log))
    rows = {run.number: int(np.searchsorted(log.columns["t_s"], run.start_t_s)) for run in runs}
    begun = {number: _utc(int(log.time_ns[row])) for number, row in rows.items()}
    return _recorded(path, log.metadata, log.complete, runs, begun, log.events)


def _recorded(
    path: Path,
    metadata: Mapping[str, Mapping[str, str]],
    complete: bool,
    runs: tuple[RunFacts, ...],
    begun: dict[int, datetime],
    events: list[Event],
) -> Recorded:
    rig_name, ended_by = metadata.get("recording", {}).get("rig_name", ""), metadata.get("closing", {}).get("ended_by", "")
    faults = sum(event.name == "fault" for event in events)
    return Recorded(path, rig_name, ended_by, complete, "recovered" in metadata, runs, begun, faults)


def _utc(stamp_ns: int) -> datetime:
    return datetime.fromtimestamp(stamp_ns * 1e-9, UTC)
