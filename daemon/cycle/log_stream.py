"""From the loop to the recorder: what is sent, and when a recording begins and ends. Nothing here waits or writes a file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from enum import IntEnum
from typing import Any, Protocol

from recording.format.event import Event, encode_event
from recording.format.fields import FIRST_CYCLE
from recording.format.layout import CycleLayout
from recording.format.set_point import StampedSetPoint, encode_set_point
from servo_control.signals import SetPoint

RECORDER_RING_S = 8.0  # of rows wait for a recorder that the disk keeps waiting


class RecordKind(IntEnum):
    """What a record to the recorder or to the supervisor holds."""

    CYCLE = 1  # one packed row
    EVENT = 2  # one encoded event
    OPEN = 3  # JSON: the controller's state before the first row, and facts about the loop
    ATTACH = 4  # name, NUL, media type, NUL, content
    CLOSE = 5  # JSON of the closing entries
    END = 6  # the loop has ended; nothing follows
    READY = 7  # JSON of the real-time facts: every device has answered, the loop begins
    REFUSED = 8  # JSON of a refusal: the loop cannot begin
    SET_POINT = 10  # one encoded set point of a run that is driven by hand
    RECORDER = 9  # JSON of the recorder's report: path of the recording, or error


class RecordSink(Protocol):
    """Takes records without waiting; `dropped` counts those it had no room for."""

    def write(self, kind: int, stamp_ns: int, data: bytes) -> bool: ...

    @property
    def dropped(self) -> int: ...


class LogStream:
    """The recording under way, if any. Stamps are Unix ns of the cycle's deadline."""

    def __init__(self, layout: CycleLayout, recorder: RecordSink, supervisor: RecordSink) -> None:
        self._layout = layout
        self._recorder = recorder
        self._supervisor = supervisor
        self._row_length = len(layout.fields)
        self._dropped_before = 0
        self.recording = False
        self.now_ns = 0  # stamp of the cycle under way
        self.cycle_number = 0
        self.t_s = 0.0

    @property
    def drops(self) -> int:
        """Records lost since the loop started."""
        return self._recorder.dropped

    @property
    def drops_in_recording(self) -> int:
        return self._recorder.dropped - self._dropped_before if self.recording else 0

    def open(self, controller_state: Mapping[str, Any], facts: Mapping[str, str]) -> None:
        """Begin a recording with the controller's state before its first row, which is that of the cycle under way. Its number goes with
        it: where the first rows are lost, the state is not that before the first row there is."""
        self._dropped_before = self._recorder.dropped
        self.recording = True
        content = {"controller_state": controller_state, "facts": {FIRST_CYCLE: str(self.cycle_number), **facts}}
        self._recorder.write(RecordKind.OPEN, self.now_ns, json.dumps(content).encode())

    def cycle(self, values: list[float]) -> None:
        """One row; `values` begins with the fields of the layout."""
        if self.recording:
            self._recorder.write(RecordKind.CYCLE, self.now_ns, self._layout.pack(values[: self._row_length]))

    def set_point(self, point: SetPoint) -> None:
        """One that the controller gets in the cycle under way."""
        if self.recording:
            self._recorder.write(RecordKind.SET_POINT, self.now_ns, encode_set_point(StampedSetPoint(self.cycle_number, self.t_s, point)))

    def event(self, level: int, name: str, text: str, values: Mapping[str, float] | None = None) -> None:
        """To the recording, if there is one, and to the supervisor."""
        data = encode_event(Event(self.cycle_number, self.t_s, level, name, text, dict(values or {})))
        if self.recording:
            self._recorder.write(RecordKind.EVENT, self.now_ns, data)
        self._supervisor.write(RecordKind.EVENT, self.now_ns, data)

    def note(self, level: int, name: str, text: str, values: Mapping[str, float]) -> None:
        """An event for the recording only: what comes again and again."""
        if self.recording:
            data = encode_event(Event(self.cycle_number, self.t_s, level, name, text, dict(values)))
            self._recorder.write(RecordKind.EVENT, self.now_ns, data)

    def attach(self, name: str, media_type: str, content: bytes) -> None:
        if self.recording:
            self._recorder.write(RecordKind.ATTACH, self.now_ns, b"\0".join((name.encode(), media_type.encode(), content)))

    def close(self, closing: Mapping[str, str]) -> None:
        if self.recording:
            self._recorder.write(RecordKind.CLOSE, self.now_ns, json.dumps(dict(closing)).encode())
            self.recording = False

    def end(self) -> None:
        self._recorder.write(RecordKind.END, self.now_ns, b"")
        self._supervisor.write(RecordKind.END, self.now_ns, b"")
