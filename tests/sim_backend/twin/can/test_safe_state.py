"""What the simulated devices do when their master falls silent: the valve's spool and the module's outputs go safe, in time."""

from __future__ import annotations

import struct
import time

import pytest

from sim_backend.twin.can.valve import Valve
from sim_backend.twin.can.valve_states import ValveState
from tests.support.sim_backend.canopen_master import FULL, command, operational, pump_sync, valve_active
from tests.support.sim_backend.twin_rig import DEADLINE_REACTION_SUB, HEARTBEAT_REACTION_SUB, IO, VALVE

MASTER = 127
HEARTBEAT_MS = 30
TICK_MS, STROKE_MS = 1, 10


def silent_after(valve: Valve, period_ms: int, stop_ms: int, until_ms: int, heartbeat: bool, set_points: bool) -> float:
    """The node alone, on a clock of our own: ms from the last sign of life until the spool is where the device wants it."""
    now = 0
    for now in range(until_ms):
        ns = now * 1_000_000
        if (now % period_ms == 0 and now <= stop_ms) or heartbeat:
            valve.on_frame(0x700 + MASTER, b"\x05", ns)
        if now <= stop_ms or set_points:
            valve.on_frame(0x200 + VALVE, struct.pack("<Hh", 0b111, FULL), ns)
        valve.tick(ns)
        valve.move(1e-3, ns)
    assert valve.safe_since_ns is not None
    return valve.safe_since_ns / 1e6 - stop_ms


def valve_alone(heartbeat_ms: int, deadline_ms: int, reactions: dict[int, int] | None = None) -> tuple[Valve, list[tuple[int, bytes]]]:
    sent: list[tuple[int, bytes]] = []
    valve = Valve("valve", VALVE, lambda cob, data: sent.append((cob, bytes(data))), (HEARTBEAT_REACTION_SUB, DEADLINE_REACTION_SUB))
    valve.start(0)
    for index, sub, value, form in (
        (0x1016, 1, MASTER << 16 | heartbeat_ms, "<I"),
        (0x1400, 5, deadline_ms, "<H"),
        (0x1029, 1, 1, "<B"),
        *((0x2830, sub, value, "<B") for sub, value in (reactions or {}).items()),
    ):
        valve.store.set_data(index, sub, struct.pack(form, value), check_writable=True)
    valve.on_nmt(bytes([1, 0]), 0)
    return valve, sent


@pytest.mark.parametrize("heartbeat_ms", [15, 30, 60, 100])
def test_spool_is_safe_a_stroke_after_the_heartbeat_time(heartbeat_ms: int) -> None:
    valve, sent = valve_alone(heartbeat_ms, 0)
    last_ms = 10 * (100 // 10)
    took_ms = silent_after(valve, 10, last_ms, 300, heartbeat=False, set_points=True)
    assert heartbeat_ms <= took_ms <= heartbeat_ms + STROKE_MS + 2 * TICK_MS
    assert valve.device_state is ValveState.FAULT_DISABLED
    assert (0x80 + VALVE, struct.pack("<HB5x", 0x8130, 0x11)) in sent


@pytest.mark.parametrize("deadline_ms", [5, 20, 50])
def test_spool_is_safe_a_stroke_after_the_last_set_point(deadline_ms: int) -> None:
    valve, sent = valve_alone(0, deadline_ms)
    took_ms = silent_after(valve, 10, 100, 300, heartbeat=True, set_points=False)
    assert deadline_ms <= took_ms <= deadline_ms + STROKE_MS + 2 * TICK_MS
    assert (0x80 + VALVE, struct.pack("<HB5x", 0x8250, 0x11)) in sent


def test_fault_reaction_chooses_the_state_and_none_leaves_the_spool_open() -> None:
    held, _ = valve_alone(30, 0, {HEARTBEAT_REACTION_SUB: 3})
    silent_after(held, 10, 100, 300, heartbeat=False, set_points=True)
    assert held.device_state is ValveState.FAULT_HOLD
    careless, _ = valve_alone(30, 0, {HEARTBEAT_REACTION_SUB: 0})
    with pytest.raises(AssertionError):
        silent_after(careless, 10, 100, 300, heartbeat=False, set_points=True)
    assert careless.device_state is ValveState.ACTIVE
    assert careless.demand_counts == FULL


def test_a_master_that_was_never_heard_is_not_missed() -> None:
    valve, _ = valve_alone(30, 0)
    for now in range(200):
        valve.tick(now * 1_000_000)
    assert valve.device_state is ValveState.INIT


def test_watch_begins_anew_when_the_time_is_written() -> None:
    valve, _ = valve_alone(30, 0)
    valve.on_frame(0x700 + MASTER, b"\x05", 0)
    valve.store.set_data(0x1016, 1, struct.pack("<I", MASTER << 16 | 50), check_writable=True)
    valve.tick(10**9)
    assert valve.device_state is ValveState.INIT


@pytest.mark.device_clock
def test_heartbeat_loss_over_the_bus_and_reset_by_edge(running) -> None:
    node = valve_active(running)
    node.sdo[0x1029][1].raw = 1
    node.sdo[0x1016][1].raw = MASTER << 16 | HEARTBEAT_MS
    emergencies: list[int] = []
    node.emcy.add_callback(lambda error: emergencies.append(error.code))

    def alive() -> None:
        running.network.send_message(0x700 + MASTER, b"\x05")
        command(running, 0b111, FULL // 50)

    pump_sync(running, 0.1, alive)
    valve = running.twin.bench.device("rotary_valve")
    assert valve.device_state is ValveState.ACTIVE
    alive()
    last_ns = time.monotonic_ns()
    pump_sync(running, 0.1, lambda: command(running, 0b111, FULL // 50))
    assert valve.device_state is ValveState.FAULT_DISABLED
    assert emergencies == [0x8130]
    assert HEARTBEAT_MS - 2 <= (valve.safe_since_ns - last_ns) / 1e6 <= HEARTBEAT_MS + STROKE_MS + 200  # a busy machine
    pump_sync(running, 0.02, lambda: command(running, 0b0111, 0))
    assert valve.device_state is ValveState.FAULT_DISABLED  # no edge of R
    command(running, 0b0001, 0)
    command(running, 0b1001, 0)
    running.eventually(lambda: valve.device_state is ValveState.DISABLED, "reset")


def test_leaving_operational_makes_an_active_valve_safe(running) -> None:
    node = valve_active(running)
    node.nmt.state = "PRE-OPERATIONAL"
    valve = running.twin.bench.device("rotary_valve")
    running.eventually(lambda: valve.device_state in (ValveState.FAULT_HOLD, ValveState.FAULT_DISABLED), "fault")


def test_error_value_of_an_output_acts_only_when_it_was_written(running) -> None:
    node = running.node(IO)
    module = running.twin.bench.device("io")
    outputs = struct.pack("<hhhh", 3000, 0, 0, 0)
    for mode, expected in ((0, 3000), (1, -5)):
        node.sdo[0x6443][1].raw = mode
        node.sdo[0x6444][1].raw = -5
        node.sdo[0x1016][1].raw = MASTER << 16 | HEARTBEAT_MS
        operational(node)
        running.network.send_message(0x700 + MASTER, b"\x05")
        running.network.send_message(0x300 + IO, outputs)
        running.eventually(lambda: module.outputs[0] == 3000, "output")
        running.eventually(lambda: node.nmt.state == "PRE-OPERATIONAL", "0x1029: communication error")
        assert module.outputs[0] == expected
