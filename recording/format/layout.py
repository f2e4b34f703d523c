"""The packed form of one cycle: field order, message definition, and one precompiled struct for all of it.

The bytes are CDR (little endian) as ROS 2 stores it: a 4-byte header, then every number at a multiple of its own size counted
from the end of the header. Explicit pad bytes put the whole record into one `struct.Struct`, so packing costs a microsecond.
"""

from __future__ import annotations

import keyword
import re
import struct
import sys
from collections.abc import Collection, Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from config.errors import LogError
from config.signal_names import SECOND_POSITION
from recording.format.event import Event, decode_event, encode_event
from recording.format.fields import CYCLE_FIELDS, Field, joint_fields, rig_fields, tip_fields
from recording.format.schema import PACKAGE, fields_of_schema, schema_of_fields

if TYPE_CHECKING:
    import numpy as np

    from config.schema.rig import Rig

__all__ = ["CDR_HEADER", "CycleLayout", "Event", "RecordLayout", "decode_event", "encode_event"]

CDR_HEADER = b"\x00\x01\x00\x00"  # plain CDR, little endian
_TWICE = "MeasuredTwice"  # of a message of a joint with a second position sensor
CYCLE_SCHEMA = f"{PACKAGE}/msg/Cycle"

_CODES = {"float64": "d", "uint64": "Q", "int64": "q", "float32": "f", "uint32": "I", "int32": "i"}
_CODES |= {"uint16": "H", "int16": "h", "uint8": "B", "int8": "b", "bool": "B"}
_ROS_NAME = re.compile(r"^(?!.*__)(?!.*_$)[a-z][a-z0-9_]*$")


class RecordLayout:
    """Where every field of a record stands. `struct` covers header and fields; `dtype` reads the same bytes with numpy."""

    def __init__(self, fields: Sequence[Field], schema_text: str, schema_name: str = CYCLE_SCHEMA) -> None:
        self.fields = tuple(fields)
        self.schema_text = schema_text
        self.schema_name = schema_name
        self.joint_names = tuple(f.name.removesuffix(".command_V") for f in self.fields if f.name.endswith(".command_V"))
        self._index = {field.name: number for number, field in enumerate(self.fields)}
        if len(self._index) != len(self.fields):
            raise LogError("a record has two fields of one name", where=schema_name, next_step="Every field name must be unique.")
        codes, self._offsets = _packed(self.fields)
        self.struct = struct.Struct(f"<{len(CDR_HEADER)}s{codes}")
        # The same bytes after the header, which `struct` packs a third faster in the machine's own order: it then copies every double.
        self._body = struct.Struct(("@" if sys.byteorder == "little" else "<") + codes)

    @cached_property
    def dtype(self) -> np.dtype[Any]:
        """For whoever reads whole columns: the daemon, which packs rows, does without numpy."""
        import numpy as np

        formats = ["<" + _CODES[field.ros_type] for field in self.fields]
        return np.dtype({"names": list(self._index), "formats": formats, "offsets": self._offsets, "itemsize": self.struct.size})

    @classmethod
    def from_schema(cls, text: str, name: str) -> RecordLayout:
        """The layout a log was written with, from the message definition it carries."""
        return RecordLayout(fields_of_schema(text), text, name)

    def index(self, name: str) -> int:
        """Position of a field in the values of pack() and unpack(). Raises KeyError for a name the record does not have."""
        return self._index[name]

    def has(self, name: str) -> bool:
        return name in self._index

    def pack(self, values: Sequence[float]) -> bytes:
        """All values in field order as one CDR message; struct.error when their number or a type is wrong."""
        return CDR_HEADER + self._body.pack(*values)

    def unpack(self, data: bytes | bytearray | memoryview) -> tuple[float, ...]:
        """The values in field order; integers stay integers."""
        return self.struct.unpack_from(data)[1:]

    def blank(self) -> list[float]:
        """A row with nothing fitted: integers 0, all else NaN. Fill it and hand it to pack()."""
        return [float("nan") if field.ros_type.startswith("float") else 0 for field in self.fields]


class CycleLayout(RecordLayout):
    """The record of a rig with these joints.

    `motions` says "rotary" (rad) or "linear" (m) for each; left out, the joint called rotary is rotary and all others linear.
    `second`: the joints with a second position sensor.
    """

    def __init__(self, joint_names: Sequence[str], motions: Sequence[str] | None = None, second: Collection[str] = ()) -> None:
        motions = motions or ["rotary" if name == "rotary" else "linear" for name in joint_names]
        fields = [*CYCLE_FIELDS, *rig_fields()]
        taken = {field.name for field in fields} | {"tip"}
        for name in joint_names:
            _check_joint_name(name, taken)
        for name, motion in zip(joint_names, motions, strict=True):
            fields += joint_fields(name, motion, name in second)
        fields += tip_fields()
        kinds = (f"{motion.capitalize()}Joint{_TWICE * (name in second)}" for name, motion in zip(joint_names, motions, strict=True))
        parts = dict(zip(joint_names, kinds, strict=True)) | {"tip": "Tip"}
        super().__init__(fields, schema_of_fields(tuple(fields), parts))

    @classmethod
    def of_rig(cls, rig: Rig) -> CycleLayout:
        return cls(tuple(rig.joints), [joint.motion for joint in rig.joints.values()], measured_twice(rig.signals))


def measured_twice(names: Iterable[str]) -> frozenset[str]:
    """The joints whose second position is among these signals or columns."""
    return frozenset(joint for joint, _, quantity in (name.rpartition(".") for name in names) if quantity == SECOND_POSITION)


def _packed(fields: Sequence[Field]) -> tuple[str, list[int]]:
    """The struct's codes with its pad bytes, without the header, and the offset of every field from the start of the message."""
    codes, offsets, position = [], [], 0
    for field in fields:
        if field.ros_type not in _CODES:
            raise LogError("a record holds a field that is no plain number", value=f"{field.ros_type} {field.name}")
        size = struct.calcsize("<" + _CODES[field.ros_type])
        padding = -position % size
        codes.append("x" * padding + _CODES[field.ros_type])
        position += padding
        offsets.append(len(CDR_HEADER) + position)
        position += size
    return "".join(codes), offsets


def _check_joint_name(name: str, taken: set[str]) -> None:
    legal = _ROS_NAME.match(name) and not keyword.iskeyword(name)
    if legal and name not in taken:
        return
    reason = "joint name is already a field of the log" if legal else "joint name cannot be stored in a log"
    advice = "Use lower case letters, digits and single underscores, starting with a letter, no Python keyword, and not " + ", ".join(
        sorted(taken)
    )
    raise LogError(reason, value=repr(name), where="joints", next_step=advice + ".")
