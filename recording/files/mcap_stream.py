"""Writes MCAP records: byte for byte what mcap's own Writer writes with ZSTD chunks, every index and every checksum, in half the time.

A message costs that Writer a dozen calls, and a chunk a compressor of its own. Here a message is two appends to the chunk, and what can
wait is counted when the chunk ends. The library still encodes the rare records.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from typing import Any, Protocol

import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode

CHUNK_BYTES = 128 * 1024  # above what 100 ms of a 1 kHz record need, so that flush() decides where chunks end
MAGIC = b"\x89MCAP0\r\n"
_COMPRESSION = "zstd"
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_MESSAGE_HEAD = 22  # bytes of it that its length counts
_FOOTER_HEAD = struct.Struct("<BQQQ")


class Stream(Protocol):
    """An unbuffered file."""

    def write(self, data: bytes, /) -> int: ...

    def tell(self) -> int: ...


class McapStream:
    """Schemas and channels stand in the chunk of the messages after them. Raises what the stream raises; times in ns."""

    def __init__(self, stream: Stream, profile: str, library: str) -> None:
        self._stream = stream
        self._crc = 0  # of everything up to the end of the data
        self._compressor = zstandard.ZstdCompressor()
        self._chunk = bytearray()
        self._entries: dict[int, list[int]] = {}  # of the chunk's messages by channel: time, offset, time, offset, ...
        self._counts: dict[int, int] = {}  # of messages by channel
        self._earliest, self._latest = 0, 0
        self._schemas: list[Any] = []
        self._channels: list[Any] = []
        self._chunk_indexes: list[Any] = []
        self._attachment_indexes: list[Any] = []
        self._metadata_indexes: list[Any] = []
        self._put(MAGIC)
        self._put(_encoded(records.Header(profile, library)))

    def register_schema(self, name: str, encoding: str, text: bytes) -> int:
        schema = records.Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=text)
        self._schemas.append(schema)
        self._append(_encoded(schema))
        return len(self._schemas)

    def register_channel(self, topic: str, encoding: str, schema: int) -> int:
        number = len(self._channels) + 1
        channel = records.Channel(id=number, topic=topic, message_encoding=encoding, schema_id=schema, metadata={})
        self._channels.append(channel)
        self._append(_encoded(channel))
        return number

    def add_message(self, channel: int, t_ns: int, data: bytes, sequence: int = 0) -> None:
        chunk, entries = self._chunk, self._entries.get(channel)
        if entries is None:
            entries = self._entries[channel] = []
        entries += (t_ns, len(chunk))
        chunk += _MESSAGE.pack(Opcode.MESSAGE, _MESSAGE_HEAD + len(data), channel, sequence, t_ns, t_ns)
        chunk += data
        if len(chunk) > CHUNK_BYTES:
            self.end_chunk()

    def add_attachment(self, t_ns: int, name: str, media_type: str, data: bytes) -> None:
        """Stands before the messages of the chunk that has not ended."""
        offset = self._stream.tell()
        encoded = _encoded(records.Attachment(log_time=t_ns, create_time=t_ns, name=name, media_type=media_type, data=data))
        self._put(encoded)
        sizes = {"offset": offset, "length": len(encoded), "data_size": len(data)}
        self._attachment_indexes.append(records.AttachmentIndex(log_time=t_ns, create_time=t_ns, name=name, media_type=media_type, **sizes))

    def add_metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Stands before the messages of the chunk that has not ended."""
        offset = self._stream.tell()
        encoded = _encoded(records.Metadata(name=name, metadata=dict(entries)))
        self._put(encoded)
        self._metadata_indexes.append(records.MetadataIndex(offset=offset, length=len(encoded), name=name))

    def end_chunk(self) -> None:
        """Everything so far is in the stream."""
        if not self._entries:
            return
        times = {channel: entries[::2] for channel, entries in self._entries.items()}
        first, last = min(map(min, times.values())), max(map(max, times.values()))
        data = self._compressor.compress(self._chunk)
        facts = {"message_start_time": first, "message_end_time": last, "compression": _COMPRESSION, "uncompressed_size": len(self._chunk)}
        chunk = _encoded(records.Chunk(data=data, uncompressed_crc=zlib.crc32(self._chunk), **facts))
        offset = self._stream.tell()
        indexes, offsets = self._message_indexes(offset + len(chunk))
        self._put(chunk + indexes)
        sizes = {"chunk_start_offset": offset, "chunk_length": len(chunk), "compressed_size": len(data)}
        facts |= {**sizes, "message_index_offsets": offsets, "message_index_length": len(indexes)}
        self._chunk_indexes.append(records.ChunkIndex(**facts))
        self._earliest, self._latest = min(first, self._earliest) if self._counts else first, max(last, self._latest)
        for channel, each in times.items():
            self._counts[channel] = self._counts.get(channel, 0) + len(each)
        self._chunk, self._entries = bytearray(), {}

    def finish(self) -> None:
        """The last chunk, and what readers find the others with."""
        self.end_chunk()
        self._put(_encoded(records.DataEnd(self._crc)))
        start = self._stream.tell()
        summary, offsets_start = self._summary(start)
        crc = zlib.crc32(_FOOTER_HEAD.pack(Opcode.FOOTER, 20, start, offsets_start), zlib.crc32(summary))
        self._stream.write(summary)
        self._stream.write(_encoded(records.Footer(start, offsets_start, crc)))
        self._stream.write(MAGIC)

    def _append(self, encoded: bytes) -> None:
        self._chunk += encoded
        if len(self._chunk) > CHUNK_BYTES:
            self.end_chunk()

    def _put(self, data: bytes) -> None:
        self._crc = zlib.crc32(data, self._crc)
        self._stream.write(data)

    def _message_indexes(self, start: int) -> tuple[bytes, dict[int, int]]:
        """Records, and where each channel's stands in the file."""
        found, offsets = b"", {}
        for channel, entries in self._entries.items():
            offsets[channel] = start + len(found)
            body = struct.pack(f"<HI{len(entries)}Q", channel, 8 * len(entries), *entries)
            found += struct.pack("<BQ", Opcode.MESSAGE_INDEX, len(body)) + body
        return found, offsets

    def _summary(self, start: int) -> tuple[bytes, int]:
        """Records, and where the offsets of their groups begin in the file."""
        counts = {"attachment_count": len(self._attachment_indexes), "metadata_count": len(self._metadata_indexes)}
        counts |= {"schema_count": len(self._schemas), "channel_count": len(self._channels), "chunk_count": len(self._chunk_indexes)}
        times = {"message_start_time": self._earliest, "message_end_time": self._latest}
        counted = {"message_count": sum(self._counts.values()), "channel_message_counts": self._counts}
        groups = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [records.Statistics(**counts, **times, **counted)]),
            (Opcode.CHUNK_INDEX, self._chunk_indexes),
            (Opcode.ATTACHMENT_INDEX, self._attachment_indexes),
            (Opcode.METADATA_INDEX, self._metadata_indexes),
        )
        summary, offsets = b"", b""
        for opcode, group in groups:
            encoded = b"".join(map(_encoded, group))
            offsets += _encoded(records.SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(encoded)))
            summary += encoded
        return summary + offsets, start + len(summary)


def _encoded(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())
