"""Writes one recording: an MCAP file that any viewer opens and that a kill of the process cuts by no more than the last flush.

Small chunks are written unbuffered, so after flush() every record so far is with the operating system; sync() also waits for the
disk and so covers a loss of power. Call them from the recorder process only: closing a chunk takes up to milliseconds.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, cast

from mcap.writer import CompressionType, Writer

from config.errors import WriteError
from config.whole_file import system_advice
from recording.format.event import EVENT_SCHEMA, EVENT_SCHEMA_TEXT, Event, encode_event
from recording.format.layout import RecordLayout
from recording.format.set_point import SET_POINT_SCHEMA, SET_POINT_SCHEMA_TEXT

CHUNK_BYTES = 128 * 1024  # above what 100 ms of a 1 kHz record need, so that flush() decides where chunks end
LIBRARY = "longreach"
CYCLE_TOPIC = "/cycle"
EVENT_TOPIC = "/event"
SET_POINT_TOPIC = "/set_point"


class LogWriter:
    """An open recording. `path` must not exist: a recording is never written over.

    `attachments` maps names to (media type, bytes), `metadata` names to string maps; both stand before the first cycle.
    Every method raises WriteError when the file cannot be written; the records up to the last flush stay readable.
    """

    def __init__(
        self,
        path: str | Path,
        layout: RecordLayout,
        attachments: Mapping[str, tuple[str, bytes]],
        metadata: Mapping[str, Mapping[str, str]],
        t_ns: int = 0,
    ) -> None:
        self.path = Path(path)
        self.cycles = 0
        self._file = _WholeWrites(self.path)
        self._writer = Writer(cast("IO[Any]", self._file), chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD, enable_data_crcs=True)
        self._writer.start(profile="ros2", library=LIBRARY)
        self._cycle_channel = self._register(CYCLE_TOPIC, layout.schema_name, layout.schema_text)
        self._event_channel = self._register(EVENT_TOPIC, EVENT_SCHEMA, EVENT_SCHEMA_TEXT)
        self._set_point_channel: int | None = None
        for name, entries in metadata.items():
            self._writer.add_metadata(name, dict(entries))
        for name, (media_type, data) in attachments.items():
            self.attach(t_ns, name, media_type, data)

    def cycle(self, t_ns: int, packed: bytes) -> None:
        """One cycle, packed by the layout; `t_ns` is its deadline in Unix nanoseconds."""
        self._writer.add_message(self._cycle_channel, t_ns, packed, t_ns, self.cycles & 0xFFFFFFFF)
        self.cycles += 1

    def event(self, t_ns: int, event: Event) -> None:
        self._writer.add_message(self._event_channel, t_ns, encode_event(event), t_ns)

    def set_point(self, t_ns: int, packed: bytes) -> None:
        """One set point, as encode_set_point made it. The topic is there from the first one on: other logs have none."""
        if self._set_point_channel is None:
            self._set_point_channel = self._register(SET_POINT_TOPIC, SET_POINT_SCHEMA, SET_POINT_SCHEMA_TEXT)
        self._writer.add_message(self._set_point_channel, t_ns, packed, t_ns)

    def attach(self, t_ns: int, name: str, media_type: str, data: bytes) -> None:
        """Store a whole file, e.g. run-1.json. Cycles before it are written out first, so the order of records is that of time."""
        self._writer.flush()
        self._writer.add_attachment(t_ns, t_ns, name, media_type, data)

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        self._writer.flush()
        self._writer.add_metadata(name, dict(entries))

    def flush(self) -> None:
        """Everything so far is with the operating system: a kill of this process loses nothing before this call."""
        self._writer.flush()

    def sync(self) -> None:
        """flush(), and wait until the disk has it: a loss of power loses nothing before this call. May take many milliseconds."""
        self._writer.flush()
        self._file.sync()

    def close(self, closing: Mapping[str, str]) -> None:
        """Write the metadata `closing` (timing passport; `complete: true` unless it says otherwise) and the index, and close the file."""
        self.metadata("closing", {"complete": "true", **closing, "cycles": str(self.cycles)})
        self._writer.finish()
        self._file.sync()
        self._file.close()

    def abandon(self) -> None:
        """Close the file without index, as a kill would leave it. For a writer whose file cannot be written any more."""
        self._file.close()

    def _register(self, topic: str, schema_name: str, schema_text: str) -> int:
        schema = self._writer.register_schema(schema_name, "ros2msg", schema_text.encode())
        return int(self._writer.register_channel(topic, "cdr", schema))


class _WholeWrites:
    """An unbuffered file that holds whole records only: a write that fails half way is taken back before the error is raised."""

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise self._refusal(error) from error
        self._length = 0
        try:
            self._sync_name()
        except OSError as error:
            os.close(self._descriptor)
            raise self._refusal(error) from error

    def write(self, data: bytes) -> int:
        view, written = memoryview(data), 0
        try:
            while written < len(view):
                written += os.write(self._descriptor, view[written:])
        except OSError as error:
            os.ftruncate(self._descriptor, self._length)
            os.lseek(self._descriptor, self._length, os.SEEK_SET)
            raise self._refusal(error) from error
        self._length += written
        return written

    def tell(self) -> int:
        return self._length

    def flush(self) -> None:
        """Nothing is buffered here; the MCAP writer asks for it."""

    def sync(self) -> None:
        try:
            os.fdatasync(self._descriptor)
        except OSError as error:
            raise self._refusal(error) from error
        if not os.fstat(self._descriptor).st_nlink:  # a deleted file takes everything without a word
            advice = "What is logged from now on has no name any more. Leave the folder of the logs alone while the daemon runs."
            raise WriteError("the log was deleted while it was written", where=str(self._path), next_step=advice)

    def close(self) -> None:
        os.close(self._descriptor)

    def _sync_name(self) -> None:
        """A synced file whose directory entry is not on the disk is lost all the same."""
        directory = os.open(self._path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(directory)
        finally:
            os.close(directory)

    def _refusal(self, error: OSError) -> WriteError:
        if isinstance(error, FileExistsError):
            advice = "Choose another name; recordings are never written over."
            return WriteError("the log exists already", where=str(self._path), next_step=advice)
        reason, advice = error.strerror or "", system_advice(error)
        return WriteError("the log cannot be written", value=reason, where=str(self._path), next_step=advice)
