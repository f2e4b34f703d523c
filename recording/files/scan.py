"""Walks over the records of an MCAP file, whole or damaged, and hands out only what is proved to be whole.

The usual MCAP readers start from the index at the end, which a cut file does not have. This one goes from the front, checks every
length and checksum, and stops (or, for a bad checksum, steps over the record) with a sentence that says where and why.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap import records as mcap_records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

MAGIC = b"\x89MCAP0\r\n"
_RECORD_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQII")  # start, end, uncompressed size, crc, length of the compression's name
_MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_LARGEST_CHUNK_BYTES = 1 << 30
BAD_INDEX = (McapError, OSError, ValueError, LookupError, ArithmeticError, MemoryError, struct.error, zstandard.ZstdError)
"""What the MCAP library's own reader, which starts from the index at the end, raises for a damaged file."""
_PRIVATE_OPCODES = 0x80  # records of other programs, to be stepped over


@dataclass(frozen=True, slots=True)
class Message:
    channel_id: int
    log_time_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class SchemaText:
    schema_id: int
    name: str
    text: str


@dataclass(frozen=True, slots=True)
class Topic:
    channel_id: int
    name: str
    schema_id: int


@dataclass(frozen=True, slots=True)
class Attached:
    log_time_ns: int
    name: str
    media_type: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Entries:
    """A metadata record: a name and a map of texts."""

    name: str
    entries: dict[str, str]


Content = SchemaText | Topic | Attached | Entries | Message


@dataclass(slots=True)
class Damage:
    """What is wrong with a file: sentences in the order of the file; `end_byte` is where the whole records end."""

    sentences: list[str] = field(default_factory=list)
    end_byte: int = 0
    closed: bool = False  # the end mark of the file was reached
    dropped_chunks: int = 0  # of records that were left out


class _BadRecordError(Exception):
    """A record whose length is right but whose content is not."""


def scan(data: bytes | memoryview, damage: Damage) -> Iterator[Content]:
    """Contents of the file in order, messages taken out of their chunks. `damage` is filled on the way. Never raises.

    Schemas and topics stand before their messages and, in a closed file, again at its end: there alone where their chunk is damaged.
    """
    view = memoryview(data)
    for opcode, start, end in _records(view, damage):
        try:
            yield from _contents(opcode, view[start:end], view[: start - _RECORD_HEAD.size])
        except _BadRecordError as error:
            damage.sentences.append(f"{error} at byte {start - _RECORD_HEAD.size}; it was left out")
            damage.dropped_chunks += opcode == Opcode.CHUNK


def _records(view: memoryview, damage: Damage) -> Iterator[tuple[int, int, int]]:
    """(opcode, start, end) of every whole record before the footer's end."""
    at = len(MAGIC)
    while True:
        damage.end_byte = at
        if len(view) - at < _RECORD_HEAD.size:
            damage.sentences.append(_end_sentence(len(view) - at))
            return
        opcode, length = _RECORD_HEAD.unpack_from(view, at)
        start = at + _RECORD_HEAD.size
        if opcode == 0 or Opcode.DATA_END < opcode < _PRIVATE_OPCODES:
            damage.sentences.append(f"there is no record at byte {at} but something else, and nothing after it can be trusted")
            return
        if length > len(view) - start:
            damage.sentences.append(f"the file ends at byte {len(view)}, in the middle of a record that starts at byte {at}")
            return
        yield opcode, start, start + length
        at = start + length
        if opcode == Opcode.FOOTER:
            damage.closed = bytes(view[at : at + len(MAGIC)]) == MAGIC
            damage.end_byte = at
            if not damage.closed:
                damage.sentences.append("the file's end mark is missing")
            elif rest := len(view) - at - len(MAGIC):
                damage.sentences.append(f"{rest} byte{'s' * (rest > 1)} that belong to no log follow the file's end mark")
            return


def _end_sentence(rest: int) -> str:
    return f"the file ends {rest} bytes into a record" if rest else "the file ends without having been closed"


def _contents(opcode: int, body: memoryview, before: memoryview) -> Iterator[Content]:
    if opcode == Opcode.CHUNK:
        yield from _in_chunk(_decompressed(body))
    elif opcode == Opcode.ATTACHMENT:
        if zlib.crc32(body[:-4]) != int.from_bytes(body[-4:], "little"):
            raise _BadRecordError("an attachment has a wrong checksum")
        yield _parsed(opcode, bytes(body))
    elif opcode == Opcode.DATA_END:
        crc = int.from_bytes(body[:4], "little")
        if crc and zlib.crc32(before) != crc:
            raise _BadRecordError("the checksum over the whole file is wrong, so something before it was altered; the end record")
    elif opcode in (Opcode.METADATA, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
        yield _single(opcode, body)


def _decompressed(body: memoryview) -> memoryview:
    """The records inside a chunk, checked against the chunk's size and checksum."""
    try:
        _, _, size, crc, name_length = _CHUNK_HEAD.unpack_from(body)
        compression = bytes(body[_CHUNK_HEAD.size : _CHUNK_HEAD.size + name_length])
        packed = body[_CHUNK_HEAD.size + name_length + 8 :]
        if size > _LARGEST_CHUNK_BYTES:
            raise _BadRecordError("a chunk claims an impossible size")
        records = _unpacked(compression, packed, size)
    except (struct.error, zstandard.ZstdError, RuntimeError, MemoryError, EOFError) as error:
        raise _BadRecordError(f"a chunk cannot be unpacked ({error})") from error
    if len(records) != size or (crc and zlib.crc32(records) != crc):
        raise _BadRecordError("a chunk has a wrong checksum")
    return memoryview(records)


def _unpacked(compression: bytes, packed: memoryview, size: int) -> bytes:
    if compression == b"zstd":
        if zstandard.frame_content_size(packed) not in (size, -1):
            raise _BadRecordError("a chunk disagrees with itself about its size")
        return zstandard.ZstdDecompressor().decompress(packed, max_output_size=size)
    if compression == b"lz4":
        return bytes(lz4.frame.decompress(packed))
    if compression == b"":
        return bytes(packed)
    raise _BadRecordError(f"a chunk uses an unknown compression {compression!r}")


def _in_chunk(records: memoryview) -> Iterator[Content]:
    at, end = 0, len(records)
    while end - at >= _RECORD_HEAD.size:
        opcode, length = _RECORD_HEAD.unpack_from(records, at)
        at += _RECORD_HEAD.size
        if length > end - at:
            raise _BadRecordError("a chunk holds a record that is longer than the chunk")
        if opcode in (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL):
            yield _single(opcode, records[at : at + length])
        at += length


def _single(opcode: int, body: memoryview) -> Content:
    if opcode != Opcode.MESSAGE:
        return _parsed(opcode, bytes(body))
    if len(body) < _MESSAGE_HEAD.size:
        raise _BadRecordError("a message is too short")
    channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(body)
    return Message(channel, log_time, bytes(body[_MESSAGE_HEAD.size :]))


def _parsed(opcode: int, body: bytes) -> Content:
    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == Opcode.SCHEMA:
            schema = mcap_records.Schema.read(stream)
            return SchemaText(schema.id, schema.name, schema.data.decode())
        if opcode == Opcode.CHANNEL:
            channel = mcap_records.Channel.read(stream)
            return Topic(channel.id, channel.topic, channel.schema_id)
        if opcode == Opcode.ATTACHMENT:
            attachment = mcap_records.Attachment.read(stream)
            return Attached(attachment.log_time, attachment.name, attachment.media_type, bytes(attachment.data))
        metadata = mcap_records.Metadata.read(stream)
        return Entries(metadata.name, dict(metadata.metadata))
    except Exception as error:  # the MCAP library raises struct, unicode and its own errors for nonsense
        raise _BadRecordError(f"a record of kind {Opcode(opcode).name} cannot be read") from error
