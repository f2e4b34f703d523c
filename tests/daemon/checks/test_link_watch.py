"""What the links count: in the facts, in the recording every second, and told when it gets worse."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from pathlib import Path

import can
import pytest

from config.loading.load import load_rig
from daemon.checks.interlocks import rig_facts
from daemon.checks.link_watch import LinkWatch
from daemon.cycle.log_stream import LogStream
from daemon.lockstep import DirectSink, LockstepRig
from daemon.modes.mode_machine import OperatorAction
from drivers.canopen.bus import CanopenBus
from drivers.canopen.counts import BUS_COUNTS, DEVICE_COUNTS, BusState
from recording.files.reader import read_log
from recording.format.event import decode_event
from recording.format.layout import CycleLayout
from servo_control.signals import Mode
from tests.support.daemon.can_daemon import can_daemon
from tests.support.daemon.proving_rig import RIG, proving_rig
from tests.support.daemon.running_daemon import until

ENCODER = "rotary_encoder"
HZ = round(RIG.rig.loop.rate_Hz)


class Counting:
    """What a driver says of itself; the numbers are the test's."""

    def __init__(self) -> None:
        self.device = dict.fromkeys(DEVICE_COUNTS, 0.0)
        self.bus = dict.fromkeys(BUS_COUNTS, 0.0)

    def counts(self) -> Mapping[str, float]:
        return self.device

    def link_counts(self) -> tuple[str, Mapping[str, float]]:
        return "can0", self.bus


def watched(rig: LockstepRig) -> Counting:
    counting = Counting()
    rig.loop._links._counting = [(ENCODER, counting)]
    return counting


def warnings(rig: LockstepRig) -> list[str]:
    return [event.text.partition("; lately ")[2] for event in rig.events if event.name == "link_trouble"]


def test_a_driver_that_cannot_count_is_told_once_and_moves_nothing(tmp_path: Path) -> None:
    def broken() -> Mapping[str, float]:
        raise OSError("adapter gone")

    with proving_rig(tmp_path) as (rig, _):
        counting = watched(rig)
        counting.device["received"] = 5.0
        rig.cycles(10)
        counting.counts = broken  # type: ignore[method-assign]
        rig.cycles(3 * HZ)
        assert rig.mode is Mode.DISARMED
        assert [event.text for event in rig.events if event.name == "device"] == [f"{ENCODER} does not say what it counts: adapter gone"]
        assert rig.value(f"{ENCODER}.received") == 5.0


def test_every_second_the_counts_are_facts(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, _):
        counting = watched(rig)
        counting.bus |= {"frames": 4000.0, "foreign": 7.0}
        counting.device["received"] = 999.0
        rig.cycles(HZ + 10)
        assert rig.value("can0.frames") == 4000.0
        assert rig.value("can0.foreign") == 7.0
        assert rig.value(f"{ENCODER}.received") == 999.0
        assert warnings(rig) == []


@pytest.mark.parametrize(
    ("count", "number", "text"),
    [
        ("can0.send_failures", 3.0, "can0.send_failures +3"),
        ("can0.error_frames", 1.0, "can0.error_frames +1"),
        ("can0.left_over", 1.0, "can0.left_over +1"),
        (f"{ENCODER}.malformed", 2.0, f"{ENCODER}.malformed +2"),
        (f"{ENCODER}.late", 0.01 * HZ + 1, f"{ENCODER}.late +{0.01 * HZ + 1:g}"),
        (f"{ENCODER}.lost", 0.01 * HZ + 2, f"{ENCODER}.lost +{0.01 * HZ + 2:g}"),
        ("can0.state", float(BusState.PASSIVE), "active → passive"),
    ],
)
def test_losses_are_told_once(tmp_path: Path, count: str, number: float, text: str) -> None:
    with proving_rig(tmp_path) as (rig, _):
        counting = watched(rig)
        rig.cycles(HZ + 10)
        owner, _, name = count.rpartition(".")
        (counting.bus if owner == "can0" else counting.device)[name] = number
        rig.cycles(3 * HZ)
        assert warnings(rig) == [text]


def test_polls_of_a_slow_device_that_fail_are_told_once() -> None:
    rig = load_rig("ornl_testbed_can").rig
    facts, told = rig_facts(rig), []
    supervisor = DirectSink(lambda kind, stamp_ns, data: told.append(decode_event(data).text))
    watch = LinkWatch(rig, {}, facts.indices, LogStream(CycleLayout.of_rig(rig), DirectSink(lambda *_: None), supervisor))
    values = facts.blank()
    for second, (polls, failed) in enumerate([(50.0, 0.0), (100.0, 4.0), (150.0, 4.0)]):
        values[facts.index("hydraulic_unit.polls")], values[facts.index("hydraulic_unit.failed_polls")] = polls, failed
        watch.update(values, second * 1_000_000_000)
    assert told == ["hydraulic_unit: 100 polls, 4 failed polls; lately hydraulic_unit.failed_polls +4"]


def test_single_late_frames_and_frames_of_others_are_no_trouble(tmp_path: Path) -> None:
    with proving_rig(tmp_path) as (rig, _):
        counting = watched(rig)
        for _ in range(5):
            counting.device["late"] += 0.005 * HZ
            counting.device["lost"] += 0.005 * HZ
            counting.bus["foreign"] += 100 * HZ
            rig.cycles(HZ)
        assert warnings(rig) == []


@pytest.mark.parametrize(
    ("classes", "controller", "state"),
    [
        (0x004, 0x08, BusState.WARNING),
        (0x004, 0x20, BusState.PASSIVE),
        (0x004, 0x10, BusState.PASSIVE),
        (0x004, 0x40, BusState.ACTIVE),
        (0x040, 0, BusState.OFF),
        (0x008, 0xFF, BusState.PASSIVE),  # a protocol violation says nothing about the controller
    ],
)
def test_the_state_of_the_controller_is_read_from_error_frames(classes: int, controller: int, state: BusState) -> None:
    """Numbers of linux/can/error.h: CAN_ERR_CRTL 4, CAN_ERR_BUSOFF 0x40, CAN_ERR_RESTARTED 0x100; warning 4, 8, passive 0x10, 0x20."""
    bus = CanopenBus.__new__(CanopenBus)
    bus.error_frames, bus.state = 0, BusState.PASSIVE
    bus._on_error_frame(classes, bytearray([0, controller, 0, 0, 0, 0, 0, 0]))
    assert bus.state is state
    bus._on_error_frame(0x040, bytearray(8))
    bus._on_error_frame(0x004, bytearray([0, 0x40, 0, 0, 0, 0, 0, 0]))
    assert bus.state is BusState.OFF, "only a restart ends bus-off"
    bus._on_error_frame(0x100, bytearray(8))
    assert bus.state is BusState.ACTIVE


@pytest.mark.device_clock
def test_a_real_bus_is_counted_in_every_recording(tmp_path: Path) -> None:
    unproven = [f"devices.{name}.demand_proof=false" for name in ("rotary_valve", "io")]
    with can_daemon(tmp_path, unproven) as daemon:
        (channel,) = {driver.link_counts()[0] for _, driver in daemon.loop._links._counting}
        daemon.post(OperatorAction.RESET)
        until(lambda: all(check.passes(daemon.loop.values) for check in daemon.loop.keeper.checks), 20.0)
        daemon.post(OperatorAction.ARM)
        until(lambda: daemon.mode is Mode.HOLDING, 5.0)
        with can.Bus(interface="virtual", channel=channel) as stranger:
            stranger.send(can.Message(arbitration_id=0x7AA, is_extended_id=False))
        until(lambda: daemon.value(f"{channel}.foreign") >= 1.0)
        interface = next(iter(daemon.loop._devices._bank.drivers.values()))._bus.can_bus  # type: ignore[attr-defined]
        send, failures = interface.send, daemon.value(f"{channel}.send_failures")

        def no_room(message: can.Message, timeout: float | None = None) -> None:
            interface.send = send
            raise can.CanOperationError("no room", errno.ENOBUFS)

        interface.send = no_room
        until(lambda: daemon.value(f"{channel}.send_failures") > failures)
        until(lambda: bool(daemon.texts("link_trouble")))
        daemon.post(OperatorAction.DISARM)
        until(lambda: bool(daemon.recorder.finished), 5.0)
        assert daemon.value("gauges.polls") > 0.0
    log = read_log(daemon.recorder.finished[0])
    of_bus = [event for event in log.events if event.name == "link" and event.text.startswith(f"{channel} active: ")]
    assert len(of_bus) >= 3, "at its beginning, every second, at its end"
    assert of_bus[-1].values[f"{channel}.frames"] > of_bus[0].values[f"{channel}.frames"] > 0
    assert of_bus[-1].values[f"{channel}.send_failures"] == failures + 1
    assert of_bus[-1].values["rotary_valve.received"] > 0
    assert any(event.name == "link" and "polls" in event.text for event in log.events)
