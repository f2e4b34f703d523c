"""The shared bus: time stamps, full transmit queues, bus-off, floods; with an interface that does what the test says."""

from __future__ import annotations

import errno
import time
from typing import Any

import can
import pytest

from config.errors import DriverError
from config.options.canopen_options import CanBus
from drivers.canopen import bus as bus_module
from drivers.canopen.bus import MOST_FRAMES, CanopenBus, acquire, release
from tests.support.drivers.canopen_rig import encoder
from tests.support.drivers.local_nodes import NodeBench

MS = 1_000_000
SETTINGS = CanBus.model_validate({"interface": "virtual", "channel": "scripted", "fault_cycles": 3})


class ScriptedInterface(can.BusABC):
    """Hands out what `incoming` holds and fails to send while `send_error` is set. `sent` keeps copies."""

    def __init__(self) -> None:
        super().__init__("scripted")
        self.incoming: list[can.Message] = []
        self.sent: list[tuple[int, bytes]] = []
        self.send_error: Exception | None = None
        self.receive_error: Exception | None = None

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self.send_error is not None:
            raise self.send_error
        self.sent.append((msg.arbitration_id, bytes(msg.data)))

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if self.receive_error is not None:
            raise self.receive_error
        return (self.incoming.pop(0) if self.incoming else None), False


@pytest.fixture
def interface() -> ScriptedInterface:
    return ScriptedInterface()


@pytest.fixture
def bus(interface: ScriptedInterface) -> CanopenBus:
    return CanopenBus(interface, SETTINGS, heartbeat_period_s=0.02)


def frame(cob_id: int, data: bytes = b"", **more: Any) -> can.Message:
    return can.Message(arbitration_id=cob_id, data=data, **{"is_extended_id": False, "timestamp": time.time(), **more})


def no_room() -> can.CanOperationError:
    return can.CanOperationError(f"Failed to transmit: {errno.errorcode[errno.ENOBUFS]}", errno.ENOBUFS)


def test_one_sync_a_cycle_and_a_heartbeat_every_period(bus: CanopenBus, interface: ScriptedInterface) -> None:
    start = 5_000 * MS
    for cycle in range(100):
        for _ in range(4):  # four devices on the bus
            bus.begin_cycle(start + cycle * MS)
    assert sum(cob_id == 0x080 for cob_id, _ in interface.sent) == 100
    heartbeats = [data for cob_id, data in interface.sent if cob_id == 0x700 + 127]
    assert heartbeats == [b"\x05"] * 5


def test_no_room_to_send_is_counted_and_an_error_after_n_cycles_without_repeating(bus: CanopenBus, interface: ScriptedInterface) -> None:
    interface.send_error = no_room()
    bus.begin_cycle(1 * MS)
    bus.begin_cycle(2 * MS)
    bus.begin_cycle(3 * MS)
    with pytest.raises(DriverError, match=r"scripted: the CAN bus is faulty \(.*ENOBUFS.*\): 3 cycles in a row \(limit: 3\)"):
        bus.begin_cycle(4 * MS)
    assert bus.send_failures == 5  # four SYNC and one heartbeat
    interface.send_error = None
    assert interface.sent == []  # nothing was kept for later


def test_two_bad_cycles_and_a_good_one_are_no_error(bus: CanopenBus, interface: ScriptedInterface) -> None:
    for cycle in range(1, 60):
        interface.send_error = no_room() if cycle % 3 else None
        bus.begin_cycle(cycle * MS)
    assert bus.send_failures > 30


def test_a_set_point_that_found_no_room_is_dropped(bus: CanopenBus, interface: ScriptedInterface) -> None:
    message = can.Message(arbitration_id=0x20B, is_extended_id=False, data=b"old!")
    interface.send_error = no_room()
    bus.send(message)
    interface.send_error = None
    message.data[:] = b"new!"
    bus.send(message)
    assert interface.sent == [(0x20B, b"new!")]


def test_bus_off_is_an_error_until_the_controller_has_restarted(bus: CanopenBus, interface: ScriptedInterface) -> None:
    interface.incoming = [frame(0x040, b"\0" * 8, is_error_frame=True)]
    for cycle in range(1, 4):
        bus.begin_cycle(cycle * MS)
    with pytest.raises(DriverError, match="the CAN controller is bus-off: 3 cycles in a row"):
        bus.begin_cycle(4 * MS)
    interface.incoming = [frame(0x100, b"\0" * 8, is_error_frame=True)]
    with pytest.raises(DriverError, match="4 cycles in a row"):
        bus.begin_cycle(5 * MS)  # the restart is heard in this cycle; it was bus-off up to now
    bus.begin_cycle(6 * MS)
    assert bus.error_frames == 2


def test_an_interface_that_has_gone_down_is_an_error(bus: CanopenBus, interface: ScriptedInterface) -> None:
    interface.receive_error = can.CanOperationError("Failed to receive: Network is down", errno.ENETDOWN)
    for cycle in range(1, 4):
        bus.begin_cycle(cycle * MS)
    with pytest.raises(DriverError, match="Network is down"):
        bus.begin_cycle(4 * MS)


def test_an_unreadable_frame_is_counted_and_the_next_one_read(bus: CanopenBus, interface: ScriptedInterface) -> None:
    seen = []
    bus.route(0x183, lambda data, stamp: seen.append(bytes(data)))
    interface.receive_error = ValueError("no CAN frame")
    bus.begin_cycle(1 * MS)
    assert bus.error_frames == MOST_FRAMES
    interface.receive_error = None
    interface.incoming = [frame(0x183, b"ok")]
    bus.begin_cycle(2 * MS)
    assert seen == [b"ok"]


def test_a_flood_takes_a_bounded_part_of_a_cycle_and_is_told(bus: CanopenBus, interface: ScriptedInterface) -> None:
    interface.incoming = [frame(0x123) for _ in range(20 * MOST_FRAMES)]
    for cycle in range(1, 4):
        bus.begin_cycle(cycle * MS)
    with pytest.raises(DriverError, match=f"more than {MOST_FRAMES} frames in one cycle"):
        bus.begin_cycle(4 * MS)
    assert bus.foreign == 4 * MOST_FRAMES


def test_frames_of_other_kinds_never_reach_a_device(bus: CanopenBus, interface: ScriptedInterface) -> None:
    seen: list[bytes] = []
    bus.route(0x183, lambda data, stamp: seen.append(bytes(data)))
    interface.incoming = [frame(0x183, is_remote_frame=True), frame(0x183, is_extended_id=True), frame(0x184, b"12345678")]
    bus.begin_cycle(1 * MS)
    assert seen == []
    assert bus.foreign == 3


def test_a_stamp_is_the_time_of_arrival_on_the_monotonic_clock(bus: CanopenBus, interface: ScriptedInterface) -> None:
    stamps: list[int] = []
    bus.route(0x183, lambda data, stamp: stamps.append(stamp))
    first = time.monotonic_ns()
    bus.begin_cycle(first)
    now = time.monotonic_ns() + 10 * MS
    arrived = time.time() + (now - time.monotonic_ns()) * 1e-9 - 0.004
    interface.incoming = [frame(0x183, timestamp=arrived)]
    before = time.monotonic_ns()
    bus.begin_cycle(before)
    assert first <= stamps[0] <= before


@pytest.mark.parametrize("step_s", [-3600.0, -0.5, 0.5, 3600.0])
def test_a_stepped_wall_clock_cannot_move_a_stamp_out_of_its_cycle(bus: CanopenBus, interface: ScriptedInterface, step_s: float) -> None:
    """The bus was empty at `first`, so the frame came between `first` and `second`, whatever its wall-clock stamp says."""
    stamps: list[int] = []
    bus.route(0x183, lambda data, stamp: stamps.append(stamp))
    first = time.monotonic_ns()
    bus.begin_cycle(first)
    interface.incoming = [frame(0x183, timestamp=time.time() + step_s)]
    second = time.monotonic_ns()
    bus.begin_cycle(second)
    assert stamps == [first if step_s < 0 else second]


def test_a_frame_that_waited_through_a_stall_is_old(bus: CanopenBus, interface: ScriptedInterface) -> None:
    """The loop stood still for 100 ms; the frame came in its first millisecond."""
    stamps: list[int] = []
    bus.route(0x183, lambda data, stamp: stamps.append(stamp))
    now = time.monotonic_ns()
    bus.begin_cycle(now - 100 * MS)
    interface.incoming = [frame(0x183, timestamp=time.time() - 0.099)]
    bus.begin_cycle(now)
    assert now - stamps[0] == pytest.approx(99 * MS, abs=2 * MS)


def test_two_devices_with_one_node_number_are_refused(bench: NodeBench) -> None:
    first, second = encoder(bench.channel, 3), encoder(bench.channel, 3)
    first.open()
    with pytest.raises(DriverError, match=r"two devices use one CAN identifier: 0x183"):
        second.open()
    second.close()
    first.close()


def test_the_last_device_closes_the_bus() -> None:
    settings = CanBus.model_validate({"interface": "virtual", "channel": "shared by two"})
    first, second = acquire(settings, 0.02), acquire(settings, 0.02)
    assert first is second
    release(first)
    first.send(can.Message(arbitration_id=0x80, is_extended_id=False))
    assert first.send_failures == 0
    release(second)
    first.send(can.Message(arbitration_id=0x80, is_extended_id=False))
    assert first.send_failures == 1
    assert settings.key not in bus_module._shared


def test_an_interface_that_cannot_be_opened_is_named() -> None:
    settings = CanBus.model_validate({"interface": "socketcan", "channel": "nosuchcan9"})
    with pytest.raises(DriverError, match=r"socketcan nosuchcan9: the CAN bus cannot be opened.*ip link"):
        acquire(settings, 0.0)
