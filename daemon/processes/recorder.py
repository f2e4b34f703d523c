"""Makes files out of what the loop sends. Used by the recorder process, and in lockstep directly."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from config.errors import LogError
from daemon.cycle.log_stream import RecordKind
from recording.files.foxglove import foxglove_layout
from recording.files.session import Session
from recording.files.writer import LogWriter
from recording.format.event import decode_event

STANDBY_ENDING = "-standby"
KEPT_STANDBY = 6  # an hour; recordings of an armed rig are never removed


class Recorder:
    """One recording at a time. `path` is that of the last one; `finished`: those that were closed with their closing entries."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._layout = session.layout()
        self._writer: LogWriter | None = None
        self.path: Path | None = None
        self.finished: list[Path] = []

    @property
    def open(self) -> bool:
        return self._writer is not None

    def handle(self, kind: int, stamp_ns: int, data: bytes) -> None:
        """One record of the loop. Raises LogError when the file cannot be written."""
        writer = self._writer
        if kind == RecordKind.CYCLE:  # first: nearly every record is one
            if writer is not None:
                writer.cycle(stamp_ns, data)
        elif kind == RecordKind.OPEN:
            self.close(stamp_ns, {"ended_by": "the next recording began"})
            content = json.loads(data)
            self._open(stamp_ns, content["controller_state"], content["facts"])
            self._drop_old_standby()
        elif writer is None:
            return  # its OPEN was dropped, which the loop knows
        elif kind == RecordKind.EVENT:
            writer.event(stamp_ns, decode_event(data))
        elif kind == RecordKind.SET_POINT:
            writer.set_point(stamp_ns, data)
        elif kind == RecordKind.ATTACH:
            name, media_type, content = data.split(b"\0", 2)
            writer.attach(stamp_ns, name.decode(), media_type.decode(), content)
        elif kind == RecordKind.CLOSE:
            self.close(stamp_ns, json.loads(data))

    def sync(self) -> None:
        """Everything so far is on the disk: neither a kill nor a loss of power takes it away."""
        if self._writer is not None:
            self._writer.sync()

    def close(self, stamp_ns: int, closing: Mapping[str, str]) -> None:
        """End the recording, if there is one, with these closing entries."""
        writer, self._writer = self._writer, None
        if writer is None:
            return
        writer.attach(stamp_ns, "timing_passport.json", "application/json", json.dumps(dict(closing), indent=1).encode())
        writer.close(closing)
        self.finished.append(writer.path)

    def abandon(self) -> None:
        """Leave the file as a kill would, after it could not be written."""
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.abandon()

    def _drop_old_standby(self) -> None:
        """Keep the newest standby recordings of this rig, so that a service that waits for weeks does not fill the disk."""
        of_this_rig = re.compile(rf"{re.escape(self._session.rig_name)}-\d{{8}}-\d{{6}}(-\d+)?{STANDBY_ENDING}\.mcap")  # a name may go on
        standby = (path for path in self._session.log_dir.iterdir() if of_this_rig.fullmatch(path.name))
        oldest_first = sorted(standby, key=lambda path: path.stat().st_mtime_ns)
        for path in oldest_first[:-KEPT_STANDBY]:
            path.unlink(missing_ok=True)

    def _open(self, stamp_ns: int, controller_state: Mapping[str, Any], loop_facts: Mapping[str, str]) -> None:
        session = self._session
        ending = STANDBY_ENDING if loop_facts.get("span") == "standby" else ""
        with suppress(OSError):  # which the writer tells
            session.log_dir.mkdir(parents=True, exist_ok=True)  # it may have been moved away since the last one
        path = _free_path(session.log_dir, session.rig_name, stamp_ns, ending)
        attachments = {
            "rig.yaml": ("application/yaml", session.rig_text.encode()),
            "calibration.json": ("application/json", json.dumps(session.calibrations, indent=1).encode()),
            "foxglove_layout.json": ("application/json", foxglove_layout(self._layout)),
            "controller_state.json": ("application/json", json.dumps(controller_state).encode()),
        }
        facts = {"recording_id": path.stem, "rig_name": session.rig_name, "rate_Hz": f"{session.rate_Hz:g}"}
        facts["started_utc"] = datetime.fromtimestamp(stamp_ns * 1e-9, UTC).isoformat()
        self._writer = LogWriter(path, self._layout, attachments, {"recording": {**facts, **session.facts, **loop_facts}}, stamp_ns)
        self._writer.flush()
        self.path = path


def _free_path(directory: Path, rig_name: str, stamp_ns: int, ending: str) -> Path:
    """`ornl_testbed-20260131-142233.mcap`, with -2, -3, ... when there are several in one second, and the ending of its span."""
    stem = f"{rig_name}-{datetime.fromtimestamp(stamp_ns * 1e-9, UTC):%Y%m%d-%H%M%S}"
    for number in range(1, 10_000):
        path = directory / (f"{stem}{ending}.mcap" if number == 1 else f"{stem}-{number}{ending}.mcap")
        if not path.exists():
            return path
    raise LogError("no free name for a recording", where=str(directory), next_step="Move old logs away.")
