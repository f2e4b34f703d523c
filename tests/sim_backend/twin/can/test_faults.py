"""Every fault of a CANopen device, injected through the control socket as another process does it, seen on the bus."""

from __future__ import annotations

import struct
import time

import pytest

from config.errors import PlantError
from sim_backend.twin.can.valve_states import ValveState
from tests.support.sim_backend.canopen_master import FULL, command, operational, pump_sync, valve_active
from tests.support.sim_backend.twin_rig import ROTARY_ENCODER, VALVE

pytestmark = pytest.mark.clock  # a device in a thread of its own must change its state within 50 ms

COB = 0x180 + ROTARY_ENCODER


@pytest.fixture
def frames(running) -> list[tuple[float, int, int]]:
    """(time, position, alarms) of the rotary encoder, which is operational."""
    operational(running.node(ROTARY_ENCODER))
    seen: list[tuple[float, int, int]] = []

    def keep(cob: int, data: bytes, stamp: float) -> None:
        position, _, alarms = struct.unpack("<IhH", data)
        seen.append((time.monotonic(), position, alarms))

    running.network.subscribe(COB, keep)
    pump_sync(running, 0.05)
    running.eventually(lambda: len(seen) > 20, "frames")
    return seen


def positions(running, frames: list[tuple[float, int, int]], seconds: float = 0.1) -> list[int]:
    frames.clear()
    pump_sync(running, seconds)
    return [position for _, position, _ in frames]


def test_silent_node_says_nothing_and_hears_nothing(running, frames) -> None:
    running.control.inject("rotary_encoder", "silent")
    pump_sync(running, 0.02)
    assert positions(running, frames) == []
    running.network.nmt.send_command(128)
    running.control.clear("rotary_encoder")
    assert len(positions(running, frames)) > 50  # still OPERATIONAL: it has not heard the command


def test_stuck_jump_and_noise(running, frames) -> None:
    rest = positions(running, frames)
    assert max(rest) - min(rest) <= 4
    running.control.inject("rotary_encoder", "jump", 5000)
    assert min(positions(running, frames)) >= max(rest) + 4990
    running.control.clear()
    running.control.inject("rotary_encoder", "noisy", 200)
    noisy = positions(running, frames)
    assert 300 < max(noisy) - min(noisy) < 3000
    running.control.inject("rotary_encoder", "stuck")
    pump_sync(running, 0.02)
    assert len(set(positions(running, frames))) == 1


def test_alarm_bits(running, frames) -> None:
    running.control.inject("rotary_encoder", "alarm", 0x0003)
    pump_sync(running, 0.02)
    frames.clear()
    pump_sync(running, 0.02)
    assert {alarms for _, _, alarms in frames} == {3}


def test_late_frames_come_that_much_later(running, frames) -> None:
    running.control.inject("rotary_encoder", "late", 20)
    running.eventually(lambda: not frames or time.monotonic() - frames[-1][0] > 0.05, "the bus is quiet")
    frames.clear()
    sent = time.monotonic()
    running.network.sync.transmit()
    running.eventually(lambda: len(frames) == 1, "the late frame")
    assert frames[0][0] - sent >= 0.0195


def test_lost_heartbeat_emcy_and_falling_out_of_operational(running, frames) -> None:
    node = running.network[ROTARY_ENCODER]
    emergencies: list[int] = []
    node.emcy.add_callback(lambda error: emergencies.append(error.code))
    running.control.inject("rotary_encoder", "emcy", 0x5001)
    running.eventually(lambda: emergencies == [0x5001], "EMCY")
    running.control.inject("rotary_encoder", "no_heartbeat")
    beats: list[bytes] = []
    running.network.subscribe(0x700 + ROTARY_ENCODER, lambda cob, data, stamp: beats.append(bytes(data)))
    pump_sync(running, 0.05)
    beats.clear()
    pump_sync(running, 0.1)
    assert beats == []
    running.control.clear()
    running.control.inject("rotary_encoder", "leave")
    assert node.nmt.wait_for_heartbeat(5) == "PRE-OPERATIONAL"


def test_wrong_state_and_device_fault_of_a_valve(running) -> None:
    valve_active(running)
    valve = running.twin.bench.device("rotary_valve")
    running.control.inject("rotary_valve", "wrong_state")
    pump_sync(running, 0.03, lambda: command(running, 0b111, FULL))
    assert valve.device_state is ValveState.DISABLED
    assert valve.demand_counts == 0
    running.control.clear("rotary_valve")
    pump_sync(running, 0.03, lambda: command(running, 0b111, 0))
    assert valve.device_state is ValveState.ACTIVE
    running.control.inject("rotary_valve", "device_fault")
    assert valve.device_state is ValveState.FAULT_DISABLED


def test_a_stuck_spool_goes_on_moving_the_joint_and_is_not_called_safe(running) -> None:
    valve_active(running)
    pump_sync(running, 0.05, lambda: command(running, 0b111, FULL // 10))
    running.control.inject("rotary_valve", "stuck")
    pump_sync(running, 0.05, lambda: command(running, 0b001, 0))
    seen = running.control.describe()["rotary_valve"]
    assert seen["state"] == "DISABLED"
    assert seen["spool"] == pytest.approx(0.1, abs=0.01)
    assert "safe_since_ns" not in seen


def test_flood(running) -> None:
    seen: list[int] = []
    running.network.subscribe(0x001, lambda cob, data, stamp: seen.append(cob))
    running.control.inject("bus", "flood", 4000)
    start = time.monotonic()
    running.eventually(lambda: len(seen) > 1000, "frames nobody asked for")
    assert time.monotonic() - start > 0.15
    running.control.clear()
    assert running.control.describe()["bus"]["flood_frames"] >= 1000


def test_answers_of_the_control_socket(running) -> None:
    assert {"plant", "rotary_encoder", "rotary_valve", "io", "gauges", "bus"} <= set(running.control.describe())
    before = time.monotonic_ns()
    assert before <= running.control.inject("rotary_valve", "jump", 1) <= time.monotonic_ns()
    for device, fault in (
        ("no_such", "stuck"),
        ("rotary_valve", "no_such"),
        ("gauges", "no_such"),
        ("plant", "no_such"),
        ("bus", "no_such"),
    ):
        with pytest.raises(PlantError, match="no such"):
            running.control.inject(device, fault)
    assert running.twin.bench.device("rotary_valve").node == VALVE
