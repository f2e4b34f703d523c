"""Nothing that can stand in a frame, an SDO, a datagram or a register makes a simulated device fail or a valve open by itself."""

from __future__ import annotations

import random
import struct

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from config.options.modbus_options import ModbusChannel
from drivers.modbus_registers import blocks
from sim_backend.plant import SimulatedRig
from sim_backend.twin.assembly import bench
from sim_backend.twin.can.valve import Valve
from sim_backend.twin.can.valve_states import ValveState
from sim_backend.twin.control_socket import obey
from sim_backend.twin.modbus.registers import words
from tests.support.sim_backend.twin_rig import IO, VALVE, twin_rig

RIG = twin_rig("fuzz", 15020)
PLANT = SimulatedRig(RIG)
LIGHT = settings(max_examples=400, deadline=None, suppress_health_check=list(HealthCheck))
NODES = (3, 4, VALVE, IO)
COB_IDS = st.one_of(
    st.integers(0, 0x7FF),
    st.sampled_from([0, 0x80, *(base + node for base in (0x200, 0x300, 0x600, 0x700) for node in NODES)]),
)
FRAMES = st.lists(st.tuples(COB_IDS, st.binary(max_size=8)), max_size=60)


@pytest.mark.slow
@LIGHT
@given(FRAMES)
def test_any_frames_in_any_order(frames: list[tuple[int, bytes]]) -> None:
    sent: list[tuple[int, bytes]] = []
    twin = bench(RIG, PLANT, lambda cob, data: sent.append((cob, data)))
    twin.start(0)
    for number, (cob_id, data) in enumerate(frames):
        twin.on_frame(cob_id, data, number * 300_000)
        twin.tick(number * 300_000)
    assert all(0 <= cob <= 0x7FF and len(data) <= 8 for cob, data in sent)


SDO_COMMANDS = st.one_of(
    st.integers(0, 255), st.sampled_from([0x40, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x21, 0x00, 0x01, 0x60, 0x70, 0x80, 0xA0, 0xC2])
)
INDICES = st.one_of(
    st.integers(0, 0xFFFF), st.sampled_from([0x1016, 0x1017, 0x1029, 0x1400, 0x1600, 0x1800, 0x1A00, 0x2830, 0x6040, 0x6300, 0x6411])
)


@LIGHT
@given(st.lists(st.tuples(SDO_COMMANDS, INDICES, st.integers(0, 255), st.binary(min_size=4, max_size=4)), max_size=60))
def test_any_sdo_requests_are_answered_and_the_device_goes_on(requests: list[tuple[int, int, int, bytes]]) -> None:
    sent: list[tuple[int, bytes]] = []
    valve = Valve("valve", VALVE, lambda cob, data: sent.append((cob, data)))
    valve.start(0)
    for number, (command, index, sub, value) in enumerate(requests):
        sent.clear()
        valve.on_frame(0x600 + VALVE, struct.pack("<BHB", command, index, sub) + value, number)
        assert len([cob for cob, _ in sent if cob == 0x580 + VALVE]) <= 1
        valve.on_sync(number)
        valve.tick(number * 1_000_000)
        assert -1.0 <= valve.move(1e-3, number) <= 2.0
    valve.on_nmt(bytes([129, VALVE]), 0)
    sent.clear()
    valve.on_frame(0x600 + VALVE, struct.pack("<BHB4x", 0x40, 0x1000, 0), 0)
    assert sent == [(0x580 + VALVE, struct.pack("<BHBI", 0x43, 0x1000, 0, 0x198))]


@LIGHT
@given(st.lists(st.tuples(st.integers(0, 0x6F), st.integers(-32768, 32767)), max_size=30))
def test_no_control_word_without_all_three_bits_opens_the_valve(words_and_points: list[tuple[int, int]]) -> None:
    valve = Valve("valve", VALVE, lambda cob, data: None)
    valve.start(0)
    valve.on_nmt(bytes([1, VALVE]), 0)
    for word, point in words_and_points:
        valve.on_frame(0x200 + VALVE, struct.pack("<Hh", word & ~0b100, point), 0)
        assert valve.device_state is not ValveState.ACTIVE
        assert valve.demand_counts == 0


WORDS = ["inject", "clear", "describe", "plant", "io", "stuck"]
KEYS = st.sampled_from(["do", "device", "fault", "amount", "x"])
JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=8) | st.sampled_from(WORDS),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=4),
    max_leaves=6,
)
TWIN = bench(RIG, PLANT, lambda cob, data: None)


@LIGHT
@given(st.dictionaries(KEYS, JSON, max_size=4))
def test_any_control_request_is_answered(request: dict[str, object]) -> None:
    assert obey(TWIN, request, 5)["now_ns"] == 5
    TWIN.feed.clear()


@pytest.mark.parametrize("order", ["big", "little"])
@pytest.mark.parametrize("kind", ["int16", "uint16", "int32", "uint32", "float32"])
@LIGHT
@given(count=st.floats(allow_nan=False, allow_infinity=False, width=32))
def test_what_the_twin_writes_the_driver_reads(kind: str, order: str, count: float) -> None:
    channel = ModbusChannel(address=3, type=kind, word_order=order)
    (block,) = blocks({"only": channel}, 0)
    ((number, raw),) = block.raw_counts(words(count, channel))
    low, high = {"int16": (-32768, 32767), "uint16": (0, 65535), "int32": (-(2**31), 2**31 - 1), "uint32": (0, 2**32 - 1)}.get(
        kind, (-float("inf"), float("inf"))
    )
    assert number == 0
    assert raw == (count if kind == "float32" else max(low, min(high, round(count) if abs(count) < 2**40 else count)))


def test_a_hundred_thousand_random_frames_leave_the_arm_where_it_is() -> None:
    """The devices are operational and their master talks nonsense: whatever happens, no valve opens without the control word 0111."""
    generator = random.Random(11)
    valve, module = TWIN.device("rotary_valve"), TWIN.device("io")
    TWIN.start(0)
    TWIN.on_frame(0, bytes([1, 0]), 0)
    start = list(PLANT.true_position)
    cob_ids = [0x80, *(base + node for base in (0x080, 0x180, 0x580, 0x600, 0x700) for node in NODES)]
    for number in range(100_000):
        data = generator.randbytes(generator.randrange(9))
        if data[1:3] != b"\x40\x60":  # an SDO write of the control word
            TWIN.on_frame(generator.choice(cob_ids), data, number * 20_000)
        assert valve.device_state is not ValveState.ACTIVE
    assert module.outputs == [0, 0, 0, 0]
    assert PLANT.true_position == pytest.approx(start, abs=2e-3)
