"""The records of McapStream beside those of mcap's own Writer, which knows nothing of it: the files must be the same, byte for byte."""

from __future__ import annotations

import io
import random
from collections.abc import Callable

import pytest
from mcap.writer import CompressionType, Writer

from recording.files.mcap_stream import CHUNK_BYTES, McapStream

LIBRARY = "longreach"


class Ours:
    """McapStream by the names of the other."""

    def __init__(self) -> None:
        self.file = io.BytesIO()
        self._stream = McapStream(self.file, "ros2", LIBRARY)

    def topic(self, name: str) -> int:
        return self._stream.register_channel(name, "cdr", self._stream.register_schema(f"msg{name}", "ros2msg", name.encode() * 40))

    def message(self, channel: int, t_ns: int, data: bytes, sequence: int) -> None:
        self._stream.add_message(channel, t_ns, data, sequence)

    def attach(self, t_ns: int, name: str, data: bytes) -> None:
        self._stream.add_attachment(t_ns, name, "text/plain", data)

    def note(self, name: str, **entries: str) -> None:
        self._stream.add_metadata(name, entries)

    def flush(self) -> None:
        self._stream.end_chunk()

    def end(self) -> bytes:
        self._stream.finish()
        return self.file.getvalue()


class Library(Ours):
    """The library's Writer, asked for the same."""

    def __init__(self) -> None:
        self.file = io.BytesIO()
        self._writer = Writer(self.file, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD, enable_data_crcs=True)
        self._writer.start(profile="ros2", library=LIBRARY)

    def topic(self, name: str) -> int:
        schema = self._writer.register_schema(f"msg{name}", "ros2msg", name.encode() * 40)
        return int(self._writer.register_channel(name, "cdr", schema))

    def message(self, channel: int, t_ns: int, data: bytes, sequence: int) -> None:
        self._writer.add_message(channel, t_ns, data, t_ns, sequence)

    def attach(self, t_ns: int, name: str, data: bytes) -> None:
        self._writer.add_attachment(t_ns, t_ns, name, "text/plain", data)

    def note(self, name: str, **entries: str) -> None:
        self._writer.add_metadata(name, entries)

    def flush(self) -> None:
        self._writer.flush()

    def end(self) -> bytes:
        self._writer.finish()
        return self.file.getvalue()


def nothing(log: Ours) -> None:
    log.topic("/cycle")


def of_the_recorder(log: Ours) -> None:
    """As a recording goes: facts, cycles in chunks of 100, events between, a topic that comes later, attachments, closing entries."""
    noise = random.Random(3)
    cycle, event = log.topic("/cycle"), log.topic("/event")
    log.note("recording", rig="bench", umlaut="Öl")
    log.attach(5, "rig.yaml", b"rig: bench\n")
    set_point = 0
    for number in range(730):
        t_ns = 1_700_000_000_000_000_000 + number * 1_000_000
        log.message(cycle, t_ns, noise.randbytes(588), number)
        if number % 150 == 20:
            log.message(event, t_ns, b"an event", 0)
        if number == 333:
            set_point = log.topic("/set_point")
        if set_point and number % 7 == 0:
            log.message(set_point, t_ns, bytes(44), 0)
        if number % 100 == 99:
            log.flush()
        if number == 450:
            log.flush()
            log.attach(t_ns, "run-1.json", b"{}")
    log.flush()
    log.note("closing", complete="true")


def in_full_chunks(log: Ours) -> None:
    """Chunks end by themselves; times go back and forth; a topic is made while a chunk is all but full."""
    noise = random.Random(4)
    cycle = log.topic("/cycle")
    for number in range(900):
        log.message(cycle, 10**18 + noise.randrange(10**6), noise.randbytes(noise.randrange(2000)), number & 7)
        if number % 90 == 0:
            log.message(log.topic(f"/{number}"), number, b"", 2**32 - 1)


@pytest.mark.parametrize("say", [nothing, of_the_recorder, in_full_chunks])
def test_the_file_is_that_of_the_library(say: Callable[[Ours], None]) -> None:
    ours, library = Ours(), Library()
    say(ours)
    say(library)
    assert ours.end() == library.end()


def test_every_flush_leaves_what_the_library_leaves() -> None:
    """What a kill leaves after it."""
    ours, library = Ours(), Library()
    for log in (ours, library):
        channel = log.topic("/cycle")
        for number in range(250):
            log.message(channel, number, bytes([number]) * 100, number)
            if number % 100 == 99:
                log.flush()
    assert ours.file.getvalue() == library.file.getvalue()
