"""`longreach twin` over udp_multicast, driven by the drivers of this project: set-up, proofs, a loop at 1 kHz, death of the controller."""

from __future__ import annotations

import random
import signal
import socket
import statistics
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import can
import pytest

from config.errors import DriverError
from daemon.faults.benches.twin_process import TwinProcess
from drivers import registry
from drivers.contract import Driver, Quality
from drivers.proof import ProvesSafeState
from sim_backend.twin.network_namespace import GROUP

pytestmark = pytest.mark.clock

PERIOD_NS = 1_000_000
VALVES = ("rotary_valve", "prismatic_valve")
GAUGES = "hydraulic_unit"
ENCODER_NODES, VALVE_NODES = (1, 2), (11, 12)
FRAMES = tuple(0x180 + node for node in (*ENCODER_NODES, *VALVE_NODES))


@pytest.fixture
def drivers(inside: None, healthy: TwinProcess) -> Iterator[dict[str, Driver]]:
    made = {name: registry.create(name, device, healthy.rig, False) for name, device in healthy.rig.devices.items()}
    for driver in made.values():
        driver.open()
    for driver in made.values():
        driver.configure()
    yield made
    for driver in made.values():
        try:
            driver.close()
        except Exception as error:  # a device that was made silent cannot confirm
            print(error)


def loop(drivers: dict[str, Driver], seconds: float, rotary: float, prismatic: float) -> list[dict[str, object]]:
    """Cycles as the control process runs them; the fast devices' samples of every cycle."""
    fast = {name: driver for name, driver in drivers.items() if name != GAUGES}
    seen, due = [], time.monotonic_ns()
    for _ in range(round(seconds * 1e9 / PERIOD_NS)):
        due = max(due + PERIOD_NS, time.monotonic_ns())
        while (left := due - time.monotonic_ns()) > 0:
            time.sleep(max(0.0, left * 1e-9 - 5e-5))
        now = time.monotonic_ns()
        samples = {name: driver.read(now) for name, driver in fast.items()}
        seen.append({name: (now - s[0].stamp_ns, s[0].raw, s[0].quality) for name, s in samples.items()})
        drivers["rotary_valve"].write([rotary], now)
        drivers["prismatic_valve"].write([prismatic], now)
    return seen


def test_outside_the_namespace_it_refuses_to_send_multicast(healthy: TwinProcess) -> None:
    command = [sys.executable, "-m", "daemon.cli.main", "twin", str(healthy.rig_file)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 1
    assert "would leave this machine" in result.stderr


def test_answers_to_sync_come_within_the_period(inside: None, healthy: TwinProcess, record_property) -> None:
    bus = can.Bus(interface="udp_multicast", channel=GROUP)
    for node in (*ENCODER_NODES, *VALVE_NODES):
        bus.send(can.Message(arbitration_id=0, data=[1, node], is_extended_id=False))
    took_us, lost = [], 0
    due = time.monotonic()
    for _ in range(2000):
        due = max(due + 1e-3, time.monotonic())
        time.sleep(max(0.0, due - time.monotonic()))
        sent = time.monotonic()
        bus.send(can.Message(arbitration_id=0x80, is_extended_id=False))
        answers = 0
        while answers < 4 and (message := bus.recv(max(0.0, sent + 0.02 - time.monotonic()))):
            answers += message.arbitration_id in FRAMES
        took_us.append(1e6 * (time.monotonic() - sent))
        lost += answers < 4
    bus.shutdown()
    took_us.sort()
    print(f"SYNC to the fourth answer: p50 {took_us[1000]:.0f} us, p99 {took_us[1980]:.0f} us, max {took_us[-1]:.0f} us, {lost} lost")
    record_property("sync_to_tpdo_p50_us", took_us[1000])
    record_property("sync_to_tpdo_p99_us", took_us[1980])
    assert lost < 20
    assert took_us[1000] < 2000  # a shared machine; about 200 us on a quiet one


def test_every_safe_state_is_proven(drivers: dict[str, Driver]) -> None:
    for name in VALVES:
        driver, results = drivers[name], []
        assert isinstance(driver, ProvesSafeState)
        for result in driver.prove_safe_state():
            results += [] if result is None else [result]
            time.sleep(1e-3)
            driver.read(time.monotonic_ns())
        assert len(results) == 2
        assert all(result.ok for result in results), [result.text for result in results]


def test_a_second_of_control_moves_both_joints(drivers: dict[str, Driver], healthy: TwinProcess) -> None:
    for driver in drivers.values():
        driver.activate()
    before = healthy.control.describe()["plant"]
    loop(drivers, 0.2, 0.0, 0.0)
    seen = loop(drivers, 1.0, 0.02, 0.1)
    after = healthy.control.describe()["plant"]
    assert after["rotary.position"] - before["rotary.position"] > 0.05
    assert after["prismatic.position"] - before["prismatic.position"] > 0.02
    for name in ("rotary_encoder", "prismatic_encoder", *VALVES):
        good = [entry[name] for entry in seen if entry[name][2] == Quality.GOOD]
        assert len(good) > 0.5 * len(seen)  # what is later than a cycle is UNCERTAIN, and this machine is shared
        assert statistics.median(age for age, _, _ in good) < 2.5e6
    signal_ = healthy.rig.signals["rotary.position"]
    count = seen[-1]["rotary_encoder"][1]
    assert signal_.calibration.offset + signal_.calibration.scale * count == pytest.approx(after["rotary.position"], abs=0.01)


def test_gauges_are_read_beside_the_bus(drivers: dict[str, Driver], healthy: TwinProcess, record_property) -> None:
    gauges, took_us = drivers[GAUGES], []
    for _ in range(200):
        start = time.perf_counter()
        samples = gauges.read(time.monotonic_ns())
        took_us.append(1e6 * (time.perf_counter() - start))
        assert {sample.quality for sample in samples} == {Quality.GOOD}
    took_us.sort()
    print(f"Modbus poll of {len(samples)} channels: p50 {took_us[100]:.0f} us, p99 {took_us[198]:.0f} us")
    record_property("modbus_poll_p50_us", took_us[100])
    healthy.control.inject(GAUGES, "black_hole")
    assert {sample.quality for sample in gauges.read(time.monotonic_ns())} == {Quality.BAD}


def until_safe(twin: TwinProcess) -> list[dict[str, Any]]:
    """What the valves say as soon as all are safe."""
    end = time.monotonic() + 2
    while time.monotonic() < end:
        devices = twin.control.describe()
        if all("safe_since_ns" in devices[name] for name in VALVES):
            return [devices[name] for name in VALVES]
    raise AssertionError(devices)


def test_when_the_controller_falls_silent_the_devices_are_safe_within_their_time(drivers: dict[str, Driver], healthy: TwinProcess) -> None:
    took_ms: list[float] = []
    for _ in range(15):
        if len(took_ms) == 5:
            break
        try:
            for driver in drivers.values():
                driver.activate()
            loop(drivers, 0.1, 0.3, -0.3)
            last_ns = time.monotonic_ns()
            valves = until_safe(healthy)
            took_ms.append(1e-6 * (max(valve["safe_since_ns"] for valve in valves) - last_ns))
            assert {valve["state"] for valve in valves} == {"FAULT_DISABLED"}
        except DriverError as stalled:  # this machine is shared: our loop stood still for longer than the devices' time-out
            print(stalled)
        for driver in drivers.values():
            driver.safe()
            driver.configure()
    print(f"from silence to safe: {[round(ms, 1) for ms in took_ms]} ms")
    assert len(took_ms) >= 3
    assert statistics.median(took_ms) < 100  # the time-out is 60 ms, three tenths of the stroke 3 ms
    assert max(took_ms) < 300  # this machine is shared


def test_frames_that_are_no_can_frames_do_not_stop_the_twin(inside: None, healthy: TwinProcess) -> None:
    noise = random.Random(5)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for _ in range(2000):
        sender.sendto(noise.randbytes(noise.randrange(1, 40)), (GROUP, 43113))
    bus = can.Bus(interface="udp_multicast", channel=GROUP)
    question = can.Message(arbitration_id=0x601, data=struct.pack("<BHB4x", 0x40, 0x1000, 0), is_extended_id=False)
    end = time.monotonic() + 5
    answered = False
    while not answered and time.monotonic() < end:
        bus.send(question)  # again, because UDP may lose it among the noise
        message = bus.recv(0.1)
        answered = message is not None and message.arbitration_id == 0x581
    bus.shutdown()
    assert answered
    assert healthy.process.poll() is None


def test_status_line_and_clean_end(healthy: TwinProcess) -> None:
    lines = [healthy.process.stdout.readline() for _ in range(3)]
    assert "twin of ornl_testbed" in lines[0]
    assert "priority" in lines[1] or "SCHED_FIFO" in lines[1]
    assert "plant" in lines[2]
    assert "SYNC" in lines[2]
    healthy.process.send_signal(signal.SIGTERM)
    rest, _ = healthy.process.communicate(timeout=10)
    assert rest.endswith("twin: stopped\n")
    assert healthy.process.returncode == 0
