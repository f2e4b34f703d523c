"""Reads a log, whole or cut, into numpy columns."""

from __future__ import annotations

import mmap
import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from config.errors import LogError
from config.loading.load import rig_from_text
from config.schema.rig import Rig
from config.whole_file import system_advice
from recording.files.scan import MAGIC, Attached, Content, Damage, Entries, Message, SchemaText, Topic, scan
from recording.files.writer import CYCLE_TOPIC, EVENT_TOPIC, SET_POINT_TOPIC
from recording.format.event import Event, decode_event
from recording.format.fields import FIRST_CYCLE
from recording.format.layout import RecordLayout
from recording.format.set_point import StampedSetPoint, decode_set_point

Column = npt.NDArray[Any]


@dataclass(slots=True)
class Log:
    """One recording. `columns` are named and typed as in the record (`rotary.command_V`), one entry a cycle.

    `time_ns` is each cycle's deadline on the wall clock (Unix ns). `complete` is true for a recording that was closed in order and
    is undamaged; otherwise `cut_text` says in a sentence what is missing. `topics`: by the number of their channel in the file.
    `set_points`: of runs that were driven by hand.
    """

    path: Path
    layout: RecordLayout
    columns: dict[str, Column]
    time_ns: npt.NDArray[np.int64]
    events: list[Event]
    attachments: dict[str, bytes]
    metadata: dict[str, dict[str, str]]
    complete: bool
    cut_text: str
    damage: Damage
    topics: dict[int, str]
    set_points: list[StampedSetPoint] = field(default_factory=list)

    @property
    def cycles(self) -> int:
        return len(self.time_ns)

    @property
    def kind(self) -> str:
        """ "imported" for data of another system; "recorded" for our own."""
        return self.metadata.get("recording", {}).get("kind", "recorded")

    @property
    def duration_s(self) -> float:
        t = self.columns["t_s"]
        return float(t[-1] - t[0]) if len(t) > 1 else 0.0

    @property
    def begun_cycle(self) -> int | None:
        """The cycle before which the controller's state in the log is; None in logs of earlier versions, which do not name it."""
        begun = self.metadata.get("recording", {}).get(FIRST_CYCLE, "")
        return int(begun) if begun.isdecimal() else None

    def counted(self, column: str) -> int:
        """How much a count that runs since the loop's start grew from the first row to the last."""
        return int(self.columns[column][-1] - self.columns[column][0])


def read_log(path: str | Path) -> Log:
    """Everything that is whole in the file. Raises LogError when it is no log of longreach or holds no cycle definition."""
    path = Path(path)
    damage, gathered = Damage(), _Gathered()
    for content in scan(log_bytes(path), damage):
        gathered.take(content)
    if gathered.layout is None:
        raise _without_cycles(path, damage, gathered)
    damage.sentences += gathered.problems
    columns = _columns(gathered.payloads, gathered.layout)
    complete = damage.closed and not damage.sentences and gathered.metadata.get("closing", {}).get("complete") == "true"
    time_ns = np.array(gathered.times, dtype=np.int64)
    cut_text = "" if complete else _cut_text(damage, columns, gathered.metadata)
    return Log(
        path=path,
        layout=gathered.layout,
        columns=columns,
        time_ns=time_ns,
        events=gathered.events,
        attachments=gathered.attachments,
        metadata=gathered.metadata,
        complete=complete,
        cut_text=cut_text,
        damage=damage,
        topics=gathered.topics,
        set_points=gathered.set_points,
    )


def open_rig(log: Log) -> Rig:
    """The rig as it was when the log was written, from the attachment rig.yaml."""
    if "rig.yaml" not in log.attachments:
        advice = "Logs of other systems have none; give the rig file with --rig where that is possible."
        raise LogError("the log has no rig file inside", where=str(log.path), next_step=advice)
    return rig_from_text(log.attachments["rig.yaml"].decode(), f"{log.path.name}:rig.yaml")


def log_bytes(path: Path) -> bytes | memoryview:
    """The file's bytes (mapped, not copied). Raises LogError for what is no MCAP file."""
    try:
        with path.open("rb") as file:
            head = file.read(64)
            if head.startswith(MAGIC):
                return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    except IsADirectoryError as error:
        raise _a_folder(path, error) from error
    except OSError as error:
        reason = error.strerror or str(error)
        raise LogError("the log cannot be opened", value=reason, where=str(path), next_step=system_advice(error)) from error
    raise _not_a_log(path, head)


def _a_folder(path: Path, error: OSError) -> LogError:
    newest = max(path.glob("*.mcap"), key=lambda log: log.stat().st_mtime, default=None)
    advice = f"A log is one file; the newest here is {newest.name}." if newest else "A log is one file; there is none here."
    mend = {str(path): str(newest)} if newest else {}
    return LogError("the log cannot be opened", value=error.strerror or str(error), where=str(path), next_step=advice, mend=mend)


@dataclass(slots=True)
class _Gathered:
    """What the scan has found so far."""

    layout: RecordLayout | None = None
    schemas: dict[int, SchemaText] = field(default_factory=dict)
    topics: dict[int, str] = field(default_factory=dict)
    early: dict[int, list[Message]] = field(default_factory=dict)  # messages whose topic is not known yet, by channel
    payloads: list[bytes] = field(default_factory=list)
    times: list[int] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    set_points: list[StampedSetPoint] = field(default_factory=list)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def take(self, content: Content) -> None:
        if isinstance(content, Message):
            self._take_message(content)
        elif isinstance(content, SchemaText):
            self.schemas[content.schema_id] = content
        elif isinstance(content, Topic):
            self._take_topic(content)
        elif isinstance(content, Attached):
            self.attachments[content.name] = content.data
        elif isinstance(content, Entries):
            self.metadata[content.name] = content.entries

    def _take_message(self, message: Message) -> None:
        topic = self.topics.get(message.channel_id)
        if topic is None:
            self.early.setdefault(message.channel_id, []).append(message)
        elif topic == CYCLE_TOPIC and self.layout is not None:
            if len(message.data) == self.layout.struct.size:
                self.payloads.append(message.data)
                self.times.append(message.log_time_ns)
            else:
                self.problems.append(f"a cycle record has {len(message.data)} bytes instead of {self.layout.struct.size}")
        elif topic in (EVENT_TOPIC, SET_POINT_TOPIC):
            try:
                self._decode(topic, message)
            except LogError as error:
                self.problems.append(str(error))

    def _decode(self, topic: str, message: Message) -> None:
        if topic == EVENT_TOPIC:
            self.events.append(decode_event(message.data))
        else:
            self.set_points.append(decode_set_point(message.data))

    def _take_topic(self, topic: Topic) -> None:
        is_cycle = topic.name == CYCLE_TOPIC
        if topic.channel_id in self.topics or (is_cycle and topic.schema_id not in self.schemas):
            return
        self.topics[topic.channel_id] = topic.name if not is_cycle or self._take_layout(self.schemas[topic.schema_id]) else ""
        for message in self.early.pop(topic.channel_id, []):
            self._take_message(message)

    def _take_layout(self, schema: SchemaText) -> bool:
        """Whether these are our records. A second channel of that name is none of ours."""
        if self.layout is not None:
            return False
        try:
            self.layout = RecordLayout.from_schema(schema.text, schema.name)
        except LogError as error:
            self.problems.append(str(error))
        return self.layout is not None

    @property
    def of_unknown_topics(self) -> int:
        return sum(map(len, self.early.values()))


def _columns(payloads: list[bytes], layout: RecordLayout) -> dict[str, Column]:
    table = np.frombuffer(b"".join(payloads), dtype=layout.dtype)
    return {field.name: np.ascontiguousarray(table[field.name]) for field in layout.fields}


def _cut_text(damage: Damage, columns: dict[str, Column], metadata: dict[str, dict[str, str]]) -> str:
    if not damage.sentences:
        return _recovered_text(columns, metadata["recovered"]) if "recovered" in metadata else "The recording was not closed."
    open_or_cut = "The log is still being recorded, or was cut"  # nothing in the file tells one from the other
    if not len(columns["t_s"]):
        return f"{open_or_cut} before its first cycle: {'; '.join(damage.sentences)}."
    cut = f"{open_or_cut} at t = {columns['t_s'][-1]:.3f} s, after cycle {columns['cycle'][-1]}"
    where, whole = ("The log is damaged", "All that was closed is here") if damage.closed else (cut, "Everything before is here")
    dropped = damage.dropped_chunks
    kept = f"{dropped} chunk{'s' * (dropped > 1)} of records left out, the rest is here" if dropped else whole
    whole_of = "the rest" if dropped else "it"
    return f"{where}: {'; '.join(damage.sentences)}. {kept}; `longreach log recover` makes a whole file of {whole_of}."


def _recovered_text(columns: dict[str, Column], recovered: dict[str, str]) -> str:
    if lost := recovered.get("damaged"):
        return f"This log was recovered: the recording had been damaged. Lost: {lost}."
    end = f"at t = {columns['t_s'][-1]:.3f} s" if len(columns["t_s"]) else "before its first cycle"
    return f"This log was recovered: the recording had been cut {end}."


def _not_a_log(path: Path, head: bytes) -> LogError:
    if not head:
        return LogError("the file is empty", where=str(path), next_step=f"Nothing was recorded into it. {_others(path)}")
    if path.suffix.lower() in (".csv", ".txt", ".tsv", ".mat"):
        advice = f"Run `longreach import {shlex.quote(str(path))} --suggest` first."
        return LogError("this is a table, not a log", where=str(path), next_step=advice)
    what = "this is not a log: the file does not start as an MCAP file"
    return LogError(what, value=repr(head[:8]), where=str(path), next_step=_others(path))


def _others(path: Path) -> str:
    return f"Give a log that longreach wrote or imported: `longreach runs {shlex.quote(str(path.parent))}` lists those there."


def _without_cycles(path: Path, damage: Damage, gathered: _Gathered) -> LogError:
    if gathered.of_unknown_topics and damage.sentences:
        what = "the part of the log that says what its messages hold is damaged"
        value, advice = damage.sentences[0], f"Its {gathered.of_unknown_topics} messages need another copy of the file. {_others(path)}"
        return LogError(what, value=value, where=str(path), next_step=advice)
    if damage.closed:
        what, advice = (
            "this MCAP file was not written by longreach: it has no /cycle records",
            _others(path),
        )
    else:
        what, advice = "the log was cut before its first cycle, or has none yet", f"There is nothing in it to recover. {_others(path)}"
    return LogError(what, value="; ".join(gathered.problems), where=str(path), next_step=advice)
