"""The record's names, its bytes, and what other people's ROS 2 decoders make of them."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from config.errors import LogError
from recording.format.fields import Field, field_of_signal, signals_of
from recording.format.layout import CDR_HEADER, CycleLayout, RecordLayout
from tests.support.recording import logs

# fmt: off
CONTRACT = [
    "cycle", "t_s", "mode", "maneuver", "segment", "late_us", "read_us", "compute_us", "write_us", "overruns", "drops", "J.target",
    "J.target_rate", "J.reference", "J.reference_rate", "J.position", "J.velocity", "J.command_V", "J.supply_pressure_Pa",
    "J.return_pressure_Pa", "J.supply_temperature_C", "J.return_temperature_C", "J.pressure_a_Pa", "J.pressure_b_Pa",
    "tip.acceleration_mps2", "tip.deflection_m", "reservoir_temperature_C",
]
# fmt: on


def decoded(path: Path, topic: str) -> list[Any]:
    """Messages as mcap-ros2-support sees them, found through the file's index."""
    with path.open("rb") as file:
        return [found.decoded_message for found in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages([topic])]


def test_every_name_of_the_contract_is_a_field() -> None:
    layout = CycleLayout(logs.JOINTS)
    for name in CONTRACT:
        for joint in logs.JOINTS:
            assert layout.has(name.replace("J.", f"{joint}."))
    assert layout.joint_names == logs.JOINTS


def test_every_signal_has_value_raw_and_age() -> None:
    layout = CycleLayout(logs.JOINTS)
    assert field_of_signal("rotary.supply_pressure") == "rotary.supply_pressure_Pa"
    for signal in signals_of(logs.JOINTS):
        assert layout.has(field_of_signal(signal))
        assert layout.has(f"{signal}_raw")
        assert layout.has(f"{signal}_age_s")


def test_eight_byte_fields_stand_at_multiples_of_eight_after_the_header() -> None:
    layout = CycleLayout(("a", "b", "c"))
    for field, (_, offset) in zip(layout.fields, layout.dtype.fields.values(), strict=True):  # type: ignore[union-attr]
        size = 8 if field.ros_type in ("float64", "uint64") else 4 if field.ros_type == "uint32" else 1
        assert (offset - len(CDR_HEADER)) % size == 0, field.name


def test_pack_and_unpack_agree() -> None:
    layout = CycleLayout(logs.JOINTS)
    row = logs.rows(layout, 1)[0]
    assert all(logs.same(a, b) for a, b in zip(layout.unpack(layout.pack(row)), row, strict=True))
    with pytest.raises(struct.error):
        layout.pack(row[:-1])


def test_the_packed_bytes_are_little_endian_at_the_offsets_of_the_layout() -> None:
    """Of every type, in an order that needs padding before most of them."""
    types = {"uint8": ("B", 7), "float64": ("d", -1.5), "int16": ("h", -3), "float32": ("f", 0.5), "bool": ("B", 1), "uint64": ("Q", 2**63)}
    types |= {"int8": ("b", -2), "int64": ("q", -(2**40)), "uint16": ("H", 65000), "uint32": ("I", 2**31), "int32": ("i", -5)}
    layout = RecordLayout([Field(f"of_{kind}", kind, "", "") for kind in types], "")
    packed = layout.pack([value for _, value in types.values()])
    assert len(packed) == layout.struct.size
    for (code, value), (_, offset) in zip(types.values(), layout.dtype.fields.values(), strict=True):  # type: ignore[union-attr]
        assert struct.unpack_from(f"<{code}", packed, offset) == (value,)


def test_a_layout_comes_back_from_its_own_message_definition() -> None:
    layout = CycleLayout(("boom", "stick"), ["rotary", "linear"])
    again = RecordLayout.from_schema(layout.schema_text, layout.schema_name)
    assert again.fields == layout.fields
    assert again.dtype == layout.dtype
    units = {field.name: field.unit for field in again.fields}
    assert units["boom.target_rate"] == "rad/s"
    assert units["stick.target_rate"] == "m/s"
    assert units["stick.supply_pressure_Pa"] == "Pa"


def test_rosbags_serialises_the_same_message_to_the_same_bytes() -> None:
    """An independent CDR encoder, fed field by field from the message definition, must give our bytes exactly."""
    layout = CycleLayout(logs.JOINTS)
    row = logs.rows(layout, 3)[2]
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(layout.schema_text, layout.schema_name))
    value = {field.name: number for field, number in zip(layout.fields, row, strict=True)}
    parts = {"rotary": "RotaryJoint", "prismatic": "LinearJoint", "tip": "Tip"}
    arguments: dict[str, object] = {name.lower(): number for name, number in value.items() if "." not in name}
    for part, kind in parts.items():
        members = {name.split(".")[1].lower(): number for name, number in value.items() if name.startswith(f"{part}.")}
        arguments[part] = store.types[f"longreach_msgs/msg/{kind}"](**members)
    message = store.types[layout.schema_name](**arguments)
    assert bytes(store.serialize_cdr(message, layout.schema_name)) == layout.pack(row)


def test_other_readers_see_the_same_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    table = logs.write(path, 250)
    layout = CycleLayout(logs.JOINTS)
    ours = decoded(path, "/cycle")
    assert len(ours) == 250
    with AnyReader([path]) as reader:
        connections = [c for c in reader.connections if c.topic == "/cycle"]
        theirs = [(t, reader.deserialize(raw, c.msgtype)) for c, t, raw in reader.messages(connections)]
    assert len(theirs) == 250
    for row, left, (t_ns, right) in list(zip(table, ours, theirs, strict=True))[::50]:
        assert t_ns == logs.START_NS + int(row[0]) * 1_000_000
        for field, value in zip(layout.fields, row, strict=True):
            for message in (left, right):
                seen = message
                for part in field.name.lower().split("."):
                    seen = getattr(seen, part)
                assert logs.same(float(seen), float(value)), field.name


def test_other_readers_see_the_events(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    logs.write(path, 250)
    events = decoded(path, "/event")
    assert [e.text for e in events] == ["mode changed at cycle 50", "mode changed at cycle 150"]
    with AnyReader([path]) as reader:
        connections = [c for c in reader.connections if c.topic == "/event"]
        event = reader.deserialize(next(reader.messages(connections))[2], connections[0].msgtype)
    assert (event.cycle, event.t_s, event.level, event.name) == (50, 0.05, 20, "mode")
    assert list(event.value_names) == ["mode"]
    assert event.values[0] == 2.0


@pytest.mark.parametrize("name", ["Boom", "a__b", "a_", "lambda", "2nd"])
def test_joint_names_no_reader_would_take_are_refused(name: str) -> None:
    with pytest.raises(LogError, match="joint name cannot be stored in a log: ") as caught:
        CycleLayout((name,))
    assert "lower case letters" in caught.value.refusal.next_step


def test_a_joint_named_like_a_field_is_refused() -> None:
    with pytest.raises(LogError, match="joints: joint name is already a field of the log: 'mode'"):
        CycleLayout(("mode",))


def test_blank_row_is_nan_where_nothing_is_fitted() -> None:
    layout = CycleLayout(("axis",))
    row = layout.blank()
    assert row[layout.index("cycle")] == 0
    assert math.isnan(row[layout.index("axis.pressure_a_Pa")])
