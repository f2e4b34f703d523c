"""Makes a whole file of a log that a kill or a loss of power has cut, and says what was lost."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from config.errors import LogError
from recording.event import decode_event
from recording.reader import Log, log_bytes, read_log
from recording.scan import MAGIC, Attached, Damage, Entries, Message, Topic, scan
from recording.writer import CYCLE_TOPIC, EVENT_TOPIC, LogWriter

CRASH_WINDOW_S = 0.25  # the recorder flushes at least this often


@dataclass(frozen=True, slots=True)
class RecoverReport:
    """What recover() found. `written` is None when the log was whole already and no file was written."""

    source: Path
    written: Path | None
    cycles: int
    events: int
    end_t_s: float
    missing_cycles: int
    lost_bytes: int
    sentences: tuple[str, ...]

    def text(self) -> str:
        if self.written is None:
            return f"{self.source} is whole ({self.cycles} cycles); nothing to repair, no file written."
        kept = f"{self.written}: {self.cycles} cycles and {self.events} events kept, up to t = {self.end_t_s:.3f} s."
        lost = f"Lost: {self.lost_bytes} bytes of unfinished records at the end (at most the last {CRASH_WINDOW_S:.2f} s before the cut)"
        inside = f", and {self.missing_cycles} cycles before that" if self.missing_cycles else ""
        return f"{kept} {lost}{inside}. Found: {'; '.join(self.sentences) or 'the recording had not been closed'}."


def recover(path: str | Path, out: str | Path) -> RecoverReport:
    """Copy everything whole from `path` into a new file `out`, with index and closing records.

    The new file appears under its name only when it is finished. Raises LogError when `out` exists or `path` holds no cycles.
    """
    source, target = Path(path), Path(out)
    log = read_log(source)
    if log.complete or "recovered" in log.metadata:
        return _report(log, None)
    if target.exists():
        raise LogError("the file to write exists already", where=str(target), next_step="Choose another name; logs are never written over.")
    temporary = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        report = _report(log, target)
        _copy(log, temporary, report)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
    return report


def was_closed(path: Path) -> bool:
    """Whether the file ends as a closed one does. Looks at the last bytes only, so a directory full of long logs takes no time."""
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - len(MAGIC)))
        return size > len(MAGIC) and file.read() == MAGIC


def _report(log: Log, written: Path | None) -> RecoverReport:
    cycle = log.columns["cycle"].astype(np.int64)
    missing = int(np.sum(np.diff(cycle) - 1)) if len(cycle) > 1 else 0
    end = float(log.columns["t_s"][-1]) if log.cycles else float("nan")
    lost = log.path.stat().st_size - log.damage.end_byte
    return RecoverReport(log.path, written, log.cycles, len(log.events), end, missing, lost, tuple(log.damage.sentences))


def _copy(log: Log, temporary: Path, report: RecoverReport) -> None:
    """Record by record in the order of the source, so that times and order stay as they were."""
    writer = LogWriter(temporary, log.layout, {}, {})
    topics: dict[int, str] = {}
    for content in scan(log_bytes(log.path), Damage()):
        if isinstance(content, Topic):
            topics[content.channel_id] = content.name
        elif isinstance(content, Entries) and content.name != "closing":
            writer.metadata(content.name, content.entries)
        elif isinstance(content, Attached):
            writer.attach(content.log_time_ns, content.name, content.media_type, content.data)
        elif isinstance(content, Message):
            _copy_message(writer, topics.get(content.channel_id, ""), content, log.layout.struct.size)
    writer.metadata("recovered", {"from": log.path.name, "what": report.text(), "lost_bytes": str(report.lost_bytes)})
    writer.close(log.metadata.get("closing", {}) | {"complete": "false"})


def _copy_message(writer: LogWriter, topic: str, message: Message, size: int) -> None:
    if topic == CYCLE_TOPIC and len(message.data) == size:
        writer.cycle(message.log_time_ns, message.data)
    elif topic == EVENT_TOPIC:
        try:
            writer.event(message.log_time_ns, decode_event(message.data))
        except LogError:
            return  # read_log has already put it into the report
