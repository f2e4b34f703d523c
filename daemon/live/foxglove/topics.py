"""The topics of a log, live: /cycle and /event with the same messages, so that a layout made for logs shows live data as well."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan
from typing import Any

from foxglove import Channel, Context, Schema

from config.loading.load import rig_from_text
from daemon.live.source.pending import Content
from recording.files.foxglove import foxglove_layout
from recording.files.writer import CYCLE_TOPIC, EVENT_TOPIC
from recording.format.event import EVENT_SCHEMA, EVENT_SCHEMA_TEXT, Event, Level, encode_event
from recording.format.layout import CycleLayout

LEVELS = {level.name.lower(): int(level) for level in Level}


class Topics:
    """Of one rig. Raw counts and ages, which live data do not carry, are NaN."""

    def __init__(self, rig: Mapping[str, Any], context: Context) -> None:
        self._layout = CycleLayout.of_rig(rig_from_text(rig["text"]))
        names = [signal["name"] for signal in rig["signals"]]
        self._at_t = 1 + rig["at_t_s"]
        whole = {field.name for field in self._layout.fields if not field.ros_type.startswith("float")}
        self._taken = [(1 + k, self._layout.index(name), name in whole) for k, name in enumerate(names) if self._layout.has(name)]
        self._cycle = _channel(CYCLE_TOPIC, self._layout.schema_name, self._layout.schema_text, context)
        self._event = _channel(EVENT_TOPIC, EVENT_SCHEMA, EVENT_SCHEMA_TEXT, context)
        self._start_unix_s = 0.0  # where t_s is 0

    def send(self, content: Content) -> None:
        """Samples and events of the feed to every client. Never waits: the SDK drops what a client does not take."""
        for row in content.get("samples", ()):
            self._start_unix_s = row[0] - (row[self._at_t] or 0.0)
            self._cycle.log(self._packed(row), log_time=round(1e9 * row[0]))
        for each in content.get("events", ()):
            event = Event(
                each["cycle"], each["t_s"], LEVELS.get(each["level"], Level.INFO), each["name"], each["text"], _numbers(each["values"])
            )
            self._event.log(encode_event(event), log_time=max(0, round(1e9 * (self._start_unix_s + each["t_s"]))))

    def close(self) -> None:
        self._cycle.close()
        self._event.close()

    def _packed(self, row: Sequence[float | None]) -> bytes:
        values = self._layout.blank()
        for source, target, whole in self._taken:
            value = row[source]
            values[target] = int(value or 0) if whole else nan if value is None else value
        return self._layout.pack(values)


def layout_of(rig: Mapping[str, Any]) -> bytes:
    """The shipped layout for this rig, as in every log."""
    return foxglove_layout(CycleLayout.of_rig(rig_from_text(rig["text"])))


def _channel(topic: str, schema: str, text: str, context: Context) -> Channel:
    return Channel(topic, schema=Schema(name=schema, encoding="ros2msg", data=text.encode()), message_encoding="cdr", context=context)


def _numbers(values: Mapping[str, float | None]) -> dict[str, float]:
    return {name: nan if value is None else value for name, value in values.items()}
