"""Copies what is whole of one log into another, record by record in the order of the source: times and order stay as they were."""

from __future__ import annotations

from collections.abc import Callable

from config.errors import LogError
from recording.files.reader import Log, log_bytes
from recording.files.scan import Attached, Damage, Entries, Message, scan
from recording.files.writer import CYCLE_TOPIC, EVENT_TOPIC, SET_POINT_TOPIC, LogWriter
from recording.format.event import decode_event

Keep = Callable[[Message | Attached | Entries], bool]


def copy_records(log: Log, writer: LogWriter, keep: Keep) -> None:
    """Of messages, attachments and metadata those that `keep` wants. What cannot be decoded is left out, as `read_log` does."""
    for content in scan(log_bytes(log.path), Damage()):
        if not isinstance(content, (Message, Attached, Entries)) or not keep(content):
            continue
        if isinstance(content, Entries):
            writer.metadata(content.name, content.entries)
        elif isinstance(content, Attached):
            writer.attach(content.log_time_ns, content.name, content.media_type, content.data)
        else:
            _copy_message(writer, log.topics.get(content.channel_id, ""), content, log.layout.struct.size)


def _copy_message(writer: LogWriter, topic: str, message: Message, size: int) -> None:
    if topic == CYCLE_TOPIC and len(message.data) == size:
        writer.cycle(message.log_time_ns, message.data)
    elif topic == SET_POINT_TOPIC:
        writer.set_point(message.log_time_ns, message.data)
    elif topic == EVENT_TOPIC:
        try:
            writer.event(message.log_time_ns, decode_event(message.data))
        except LogError:
            return  # read_log has already put it into the report
