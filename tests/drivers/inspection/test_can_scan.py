"""Nodes of the canopen package are found, identified, and left exactly as they were; a bus with a master is only listened to."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator
from typing import Any

import can
import pytest

from config.errors import DriverError
from config.options.canopen_options import CanBus
from drivers.inspection import can_scan
from drivers.inspection.can_scan import BusScan, scan_bus, scan_rates
from drivers.inspection.sources import can_to_ask
from tests.support.drivers.local_nodes import PRE_OPERATIONAL, EncoderNode, IoNode, NodeBench, ValveNode

READS = {0b010, 0b011, 0b100}  # command specifiers of SDO requests: initiate upload, upload segment, abort (CiA 301, 7.2.4.3)


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[NodeBench]:
    with NodeBench(request.node.nodeid) as made:
        yield made


@pytest.fixture
def frames(bench: NodeBench) -> Iterator[list[can.Message]]:
    """Everything that is sent on the bus, by whomever."""
    heard: list[can.Message] = []
    notifier = can.Notifier(can.Bus(interface="virtual", channel=bench.channel), [heard.append], 0.01)
    yield heard
    notifier.stop()


def ours(frames: list[can.Message]) -> list[can.Message]:
    """Without what the nodes send: answers, and the boot-up message."""
    return [frame for frame in frames if frame.arbitration_id & 0x780 not in (0x580, 0x700)]


def scan(bench: NodeBench, **changes: Any) -> BusScan:
    bus = CanBus(interface="virtual", channel=bench.channel)
    how = {"nodes": range(1, 128), "listen_s": 0.1, "only_listen": False, **changes}
    return scan_bus(bus, **how, progress=lambda _: None)


def test_every_node_is_found_with_its_identity_and_nothing_is_written(bench: NodeBench, frames: list[can.Message]) -> None:
    encoder, valve, module = EncoderNode(bench, 3), ValveNode(bench, 11), IoNode(bench, 127)
    encoder.put(0x1018, 1, 0x2F)
    encoder.put(0x1018, 4, 123_456_789)
    found = scan(bench)
    assert found.passive == ""
    identities = {node.node: node.identity for node in found.nodes}
    assert {number: (who.profile, who.driver) for number, who in identities.items() if who} == {
        3: (406, "canopen_encoder_406"),
        11: (408, "canopen_valve_408"),
        127: (401, "canopen_io_401"),
    }
    assert identities[3] is not None
    assert (identities[3].vendor, identities[3].serial) == (0x2F, 123_456_789)
    bench.settle()
    requests = ours(frames)
    assert requests
    assert {frame.arbitration_id & 0x780 for frame in requests} == {0x600}, "only SDO requests"
    assert {frame.data[0] >> 5 for frame in requests} <= READS
    assert [node.state for node in (encoder, valve, module)] == [PRE_OPERATIONAL] * 3


def test_a_name_longer_than_one_frame_is_read(bench: NodeBench) -> None:
    node = EncoderNode(bench, 5)
    node.local.object_dictionary.add_object(_text(0x1008, "Manufacturer device name", "Absolute encoder AC58"))
    (found,) = scan(bench, nodes=[5]).nodes
    assert found.identity is not None
    assert found.identity.name == "Absolute encoder AC58"


def test_where_a_master_speaks_nothing_is_sent(bench: NodeBench, frames: list[can.Message]) -> None:
    node = EncoderNode(bench, 3)
    node.local.nmt.start_heartbeat(20)
    master = can.Bus(interface="virtual", channel=bench.channel)
    task = master.send_periodic(can.Message(arbitration_id=0x80, is_extended_id=False), 0.01)
    try:
        found = scan(bench, listen_s=0.3)
        with pytest.raises(DriverError, match="a master speaks on this bus"), can_to_ask(found.bus):
            pass
    finally:
        task.stop()
        master.shutdown()
    assert found.passive == "a master speaks on this bus (SYNC)"
    assert [(each.node, each.identity) for each in found.nodes] == [(3, None)]
    assert found.nodes[0].heard == ("pre-operational",)
    assert {frame.arbitration_id for frame in frames} <= {0x80, 0x703}


def test_another_process_on_the_bus_makes_it_passive(bench: NodeBench, frames: list[can.Message], monkeypatch: pytest.MonkeyPatch) -> None:
    EncoderNode(bench, 3)
    monkeypatch.setattr(can_scan, "holder", lambda link: 4711)
    found = scan(bench)
    assert found.passive == "process 4711 of longreach speaks on this bus"
    bench.settle()
    assert (found.nodes, ours(frames)) == ((), [])


def test_what_is_heard_is_named(bench: NodeBench) -> None:
    node = can.Bus(interface="virtual", channel=bench.channel)
    told = [(0x705, b"\0"), (0x705, b"\x7f"), (0x085, struct.pack("<HB5x", 0x8130, 0x11)), (0x185, bytes(8)), (0x286, bytes(8))]
    frames = [can.Message(arbitration_id=cob, data=data, is_extended_id=False) for cob, data in told]
    sender = threading.Timer(0.1, lambda: [node.send(frame) for frame in frames])
    sender.start()
    found = scan(bench, listen_s=0.6, only_listen=True)
    sender.join()
    node.shutdown()
    assert {each.node: each.heard for each in found.nodes} == {
        5: ("boot-up", "pre-operational", "emergency 0x8130", "TPDO1"),
        6: ("TPDO2",),
    }
    assert found.frames == len(told)


def test_with_several_bit_rates_nobody_is_asked_where_frames_are_garbled(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stand-in for the interface: at 250 kbit/s frames are heard, elsewhere the controller sees errors."""
    asked: list[tuple[float, bool]] = []

    def fake(bus: CanBus, nodes: object, listen_s: float, only_listen: bool, progress: object) -> BusScan:
        asked.append((bus.bitrate, only_listen))
        right = bus.bitrate == 250e3
        return BusScan(bus, 7 if right else 0, 0 if right else 3, "", ())

    monkeypatch.setattr(can_scan, "scan_bus", fake)
    scan_rates(CanBus(interface="virtual", channel="rates"), [1e6, 500e3, 250e3], [1], 0.1, False, lambda _: None)
    assert asked == [(1e6, True), (500e3, True), (250e3, True), (250e3, False)]


def _text(index: int, name: str, value: str) -> Any:
    from canopen import objectdictionary as od

    variable = od.ODVariable(name, index)
    variable.data_type, variable.access_type, variable.default, variable.value = od.VISIBLE_STRING, "const", value, value
    return variable
