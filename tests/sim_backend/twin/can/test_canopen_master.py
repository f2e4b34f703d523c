"""The twin driven by a master that is not ours: RemoteNode of the canopen package, over a virtual bus."""

from __future__ import annotations

import math
import struct
import time

import canopen
import pytest

from tests.support.sim_backend.canopen_master import FULL, command, operational, pump_sync, valve_active
from tests.support.sim_backend.twin_rig import IO, PRISMATIC_ENCODER, ROTARY_ENCODER, VALVE


@pytest.mark.parametrize(("number", "profile"), [(ROTARY_ENCODER, 406), (VALVE, 408), (IO, 401)])
def test_identity_is_read_by_sdo(running, number: int, profile: int) -> None:
    node = running.node(number)
    assert node.sdo[0x1000].raw & 0xFFFF == profile
    assert node.sdo[0x1018][0].raw == 4
    assert node.sdo[0x1018][3].raw == node.object_dictionary[0x1018][3].default


def test_unknown_objects_and_read_only_ones_are_refused_with_the_right_abort_codes(running) -> None:
    node = running.node(ROTARY_ENCODER)
    for index, sub, code in ((0x5FFF, 0, 0x06020000), (0x1018, 9, 0x06090011)):
        with pytest.raises(canopen.SdoAbortedError) as refusal:
            node.sdo.upload(index, sub)
        assert refusal.value.code == code
    with pytest.raises(canopen.SdoAbortedError) as refusal:
        node.sdo.download(0x6004, 0, b"\0\0\0\0")
    assert refusal.value.code == 0x06010002
    with pytest.raises(canopen.SdoAbortedError) as refusal:
        node.sdo.download(0x1017, 0, b"\0\0\0\0")
    assert refusal.value.code == 0x06070010


def test_nmt_states_heartbeat_and_boot_up(running) -> None:
    node = running.node(PRISMATIC_ENCODER)
    node.sdo[0x1017].raw = 20
    for state in ("OPERATIONAL", "PRE-OPERATIONAL", "OPERATIONAL", "STOPPED"):
        node.nmt.state = state
        running.eventually(lambda state=state: node.nmt.wait_for_heartbeat(5) == state, state)
    node.sdo.RESPONSE_TIMEOUT = 0.1
    with pytest.raises(canopen.SdoCommunicationError):
        node.sdo.upload(0x1000, 0)  # no SDO in STOPPED (CiA 301)
    node.sdo.RESPONSE_TIMEOUT = 5.0
    node.nmt.state = "RESET"
    node.nmt.wait_for_bootup(5)
    assert node.sdo[0x1017].raw == 0  # what was written is gone


def test_encoder_answers_sync_with_position_speed_and_alarms(running) -> None:
    node = running.node(ROTARY_ENCODER)
    operational(node)
    frames: list[bytes] = []
    running.network.subscribe(0x180 + ROTARY_ENCODER, lambda cob, data, stamp: frames.append(bytes(data)))
    pump_sync(running, 0.1)
    running.eventually(lambda: len(frames) + running.twin.bench.unanswered >= 90, "a frame a SYNC that did not come too late")
    assert frames
    position, speed, alarms = struct.unpack("<IhH", frames[-1])
    signal = running.rig.signals["rotary.position"]
    assert signal.calibration.offset + signal.calibration.scale * position == pytest.approx(
        running.twin.bench.feed.plant.true_position[0], abs=math.radians(0.1)
    )
    assert abs(speed) < 400
    assert alarms == 0
    assert node.sdo[0x6501].raw == 72000


def test_plant_time_is_the_number_of_syncs(running) -> None:
    running.eventually(lambda: running.twin.bench.clock.caught_up > 0, "free running")
    pump_sync(running, 0.02)
    bench = running.twin.bench
    before_s, before_syncs, before_caught = bench.feed.plant.time_s, bench.syncs, bench.clock.caught_up
    pump_sync(running, 0.3)
    stepped = round((bench.feed.plant.time_s - before_s) / bench.feed.period_s)
    caught_up = bench.clock.caught_up - before_caught
    assert stepped == bench.syncs - before_syncs + caught_up


def test_valve_goes_through_its_states_by_control_word(running) -> None:
    node = running.node(VALVE)
    operational(node)
    for word, status in ((0b001, 0b1001), (0b011, 0b1011), (0b111, 0b1111), (0b011, 0b1011), (0b000, 0b1000), (0b110, 0b1000)):
        command(running, word, 0)
        running.eventually(lambda status=status: node.sdo[0x6041].raw == status, f"{word:b} → {status:b}")


def test_spool_follows_the_set_point_only_in_active(running) -> None:
    node = valve_active(running)
    frames: list[tuple[int, int]] = []
    running.network.subscribe(0x180 + VALVE, lambda cob, data, stamp: frames.append(struct.unpack("<Hh", data)))
    pump_sync(running, 0.05, lambda: command(running, 0b111, FULL // 4))
    running.eventually(lambda: frames[-1] == (0b1111, FULL // 4), "actual = set point")
    node.sdo[0x6314][1].raw = -300
    pump_sync(running, 0.05, lambda: command(running, 0b011, FULL // 4))
    running.eventually(lambda: frames[-1] == (0b1011, -300), "hold set point in HOLD")
    pump_sync(running, 0.05, lambda: command(running, 0b001, FULL // 4))
    running.eventually(lambda: frames[-1] == (0b1001, 0), "fail-safe position when DISABLED")


def test_joint_moves_with_the_valve_and_stands_without(running) -> None:
    valve_active(running)
    plant = running.twin.bench.feed.plant
    start = plant.true_position[0]
    pump_sync(running, 0.3, lambda: command(running, 0b111, FULL // 20))
    assert plant.true_position[0] - start > 0.02
    pump_sync(running, 0.2, lambda: command(running, 0b001, FULL // 20))
    stopped = plant.true_position[0]
    pump_sync(running, 0.2, lambda: command(running, 0b001, FULL // 20))
    assert plant.true_position[0] == pytest.approx(stopped, abs=2e-3)


def test_analogue_output_moves_the_other_joint_and_input_shows_acceleration(running) -> None:
    node = running.node(IO)
    operational(node)
    plant = running.twin.bench.feed.plant
    start = plant.true_position[1]
    out = struct.pack("<hhhh", round(1.0 * 3276.7), 0, 0, 0)
    frames: list[int] = []
    running.network.subscribe(0x280 + IO, lambda cob, data, stamp: frames.append(struct.unpack("<h6x", data)[0]))
    pump_sync(running, 0.3, lambda: running.network.send_message(0x300 + IO, out))
    assert abs(plant.true_position[1] - start) > 5e-3
    assert len(set(frames)) > 3


def test_mapping_can_be_changed_as_cia_301_says(running) -> None:
    node = running.node(ROTARY_ENCODER)
    pdo = node.tpdo[1]
    pdo.read()
    with pytest.raises(canopen.SdoAbortedError):
        node.sdo[0x1A00][1].raw = 0x65030010  # while the PDO is on
    pdo.clear()
    pdo.add_variable(0x6503)
    pdo.add_variable(0x6004)
    pdo.trans_type = 2
    pdo.enabled = True
    pdo.save()
    operational(node)
    frames: list[bytes] = []
    running.network.subscribe(0x180 + ROTARY_ENCODER, lambda cob, data, stamp: frames.append(bytes(data)))
    pump_sync(running, 0.05)
    time.sleep(0)
    assert {len(frame) for frame in frames} == {6}
    assert len(frames) <= running.twin.bench.syncs // 2 + 1
