"""Objects of a CANopen node by their place in its dictionary: name, type, and what their bytes mean.

The type comes from an EDS file, from the channel that a driver declares, or from the user; without any, from the number of bytes.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import canopen
from canopen import objectdictionary as od

import config
from config.errors import ConfigError
from config.options.device_options import Channel

FORMS = {"u8": "<B", "u16": "<H", "u32": "<I", "u64": "<Q", "i8": "<b", "i16": "<h", "i32": "<i", "i64": "<q", "f32": "<f", "f64": "<d"}
TEXT = "text"
_OF_EDS = {
    od.BOOLEAN: "u8", od.UNSIGNED8: "u8", od.UNSIGNED16: "u16", od.UNSIGNED32: "u32", od.UNSIGNED64: "u64",
    od.INTEGER8: "i8", od.INTEGER16: "i16", od.INTEGER32: "i32", od.INTEGER64: "i64", od.REAL32: "f32", od.REAL64: "f64",
    od.VISIBLE_STRING: TEXT,
}  # fmt: skip
_OF_SIZE = {1: "u8", 2: "u16", 4: "u32", 8: "u64"}
_WORD = re.compile(r"(?:0x)?([0-9a-fA-F]{1,4})(?::(\d{1,3}))?(?:/(\w+))?")
# The shipped dictionaries, by the number of the CiA profile.
EDS = {401: "io_401.eds", 406: "encoder_406.eds", 408: "valve_408.eds"}


@dataclass(frozen=True, slots=True)
class NodeObject:
    """`type`: a key of FORMS, TEXT, or empty where the number of bytes decides."""

    index: int
    sub: int
    name: str = ""
    type: str = ""

    @property
    def place(self) -> str:
        return f"0x{self.index:04X}:{self.sub}"

    def value(self, content: bytes) -> float | str:
        """What the bytes of the object mean; bytes that fit no number are shown as they are."""
        kind = self.type or _OF_SIZE.get(len(content), "")
        if kind == TEXT:
            return content.split(b"\0")[0].decode("ascii", "replace")
        form = FORMS.get(kind)
        if form is None or len(content) < struct.calcsize(form):
            return content.hex(" ")
        return float(struct.unpack(form, content[: struct.calcsize(form)])[0])


def of_word(word: str, known: dict[tuple[int, int], NodeObject]) -> NodeObject:
    """ "6401:2" or "0x6401:2/i16", in hexadecimal as data sheets have it. ConfigError for anything else."""
    found = _WORD.fullmatch(word)
    if found is None or (found[3] and found[3] not in (*FORMS, TEXT)) or int(found[2] or 0) > 255:
        advice = f"Write INDEX[:SUB][/TYPE] with a hexadecimal index, for example 6004 or 6401:2/i16; types: {', '.join((*FORMS, TEXT))}."
        raise ConfigError("not an object", value=word, where="--object", next_step=advice, mend={word: "6401:2/i16"})
    index, sub = int(found[1], 16), int(found[2] or 0)
    listed = known.get((index, sub), NodeObject(index, sub))
    return NodeObject(index, sub, listed.name, found[3] or listed.type)


def of_channel(name: str, channel: Channel) -> NodeObject:
    """The object that a driver maps to a channel. A channel that goes below zero is signed, as all analogue outputs are."""
    index, sub, bits = channel.mapped >> 16, channel.mapped >> 8 & 0xFF, channel.mapped & 0xFF
    signed = channel.low is not None and channel.low < 0
    return NodeObject(index, sub, name, f"{'i' if signed else 'u'}{bits}")


def of_eds(eds: Path | None, profile: int, node: int) -> dict[tuple[int, int], NodeObject]:
    """Every readable object of a dictionary by (index, sub-index): the maker's EDS, else the shipped one of the profile."""
    shipped = EDS.get(profile)
    path = eds or (Path(config.__file__).parent / "eds" / shipped if shipped else None)
    if path is None:
        return {}
    try:
        objects = canopen.import_od(str(path), node)
    except Exception as error:  # configparser, values that are no numbers, a file that is not there
        value = f"{type(error).__name__}: {error}"
        raise ConfigError("the EDS file cannot be read", value=value, where=str(path), next_step="Use the one of the maker.") from error
    return {(entry.index, entry.subindex): _object(entry) for entry in _entries(objects) if entry.readable}


def _entries(objects: Any) -> Iterator[Any]:
    for item in objects.values():
        yield from [item] if isinstance(item, od.ODVariable) else item.values()


def _object(entry: Any) -> NodeObject:
    parent = f"{entry.parent.name}, " if isinstance(entry.parent, (od.ODRecord, od.ODArray)) else ""
    return NodeObject(entry.index, entry.subindex, f"{parent}{entry.name}", _OF_EDS.get(entry.data_type, ""))
