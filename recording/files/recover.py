"""Makes a whole file of what is left of a log that was cut by a kill or a loss of power, or damaged, and says what was lost."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from config.whole_file import refuse_existing, replaced_when_done
from recording.files.copying import copy_records
from recording.files.reader import Log, read_log
from recording.files.scan import MAGIC, Entries
from recording.files.writer import LogWriter

CRASH_WINDOW_S = 0.25  # the recorder flushes at least this often


@dataclass(frozen=True, slots=True)
class RecoverReport:
    """What recover() found. `written` is None when the log was whole already and no file was written. `closed`: the log's end is there, so
    it was not cut but damaged since."""

    source: Path
    written: Path | None
    cycles: int
    events: int
    end_t_s: float
    closed: bool
    missing_cycles: int
    lost_bytes: int
    dropped_chunks: int
    sentences: tuple[str, ...]

    def text(self) -> str:
        if self.written is None:
            return f"{self.source} is whole ({self.cycles} cycles); nothing to repair, no file written."
        kept = f"{self.written}: {self.cycles} cycles and {self.events} events kept, up to t = {self.end_t_s:.3f} s."
        found = "; ".join(self.sentences) or "the recording had not been closed"
        return f"{kept} Lost: {self.lost}. Found: {found}."

    @property
    def lost(self) -> str:
        """Nothing is lost at the end of a file that was closed."""
        unfinished = f"{self.lost_bytes} bytes of unfinished records at the end (at most the last {CRASH_WINDOW_S:.2f} s before the cut)"
        parts = [] if self.closed else [unfinished]
        parts += [f"{self.missing_cycles} cycles before the end"] if self.missing_cycles else []
        chunks = self.dropped_chunks
        parts += [f"{chunks} damaged chunk{'s' * (chunks > 1)} of records"] if chunks else []
        return ", and ".join(parts) or "no cycle"


def recover(path: str | Path, out: str | Path) -> RecoverReport:
    """Copy everything whole from `path` into a new file `out`, with index and closing records.

    The new file appears under its name only when it is finished. Raises UsageError when `out` exists, LogError when `path` holds no cycles.
    """
    source, target = Path(path), Path(out)
    log = read_log(source)
    if log.complete or ("recovered" in log.metadata and not log.damage.sentences):
        return _report(log, None)
    refuse_existing(target, "file to write", "Choose another name; logs are never written over.")
    report = _report(log, target)
    with replaced_when_done(target) as temporary:
        _copy(log, temporary, report)
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
    events, damage = len(log.events), log.damage
    lost, sentences = 0 if damage.closed else log.path.stat().st_size - damage.end_byte, tuple(damage.sentences)
    return RecoverReport(log.path, written, log.cycles, events, end, damage.closed, missing, lost, damage.dropped_chunks, sentences)


def _copy(log: Log, temporary: Path, report: RecoverReport) -> None:
    writer = LogWriter(temporary, log.layout, {}, {})
    copy_records(log, writer, lambda content: not (isinstance(content, Entries) and content.name == "closing"))
    about = {"from": log.path.name, "what": report.text(), "lost_bytes": str(report.lost_bytes)}
    writer.metadata("recovered", about | ({"damaged": report.lost} if report.closed else {}))
    writer.close(log.metadata.get("closing", {}) | {"complete": "false"})
