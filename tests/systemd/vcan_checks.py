"""What only a real SocketCAN shows; run inside the user-mode Linux by test_socketcan.py."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator

import can
import pytest

from config.errors import DriverError
from config.options.canopen_options import CanBus
from drivers.canopen.bus import CanopenBus, acquire, release
from tests.systemd.vcan_plugin import new_interface

FAULT_CYCLES = 5


@pytest.fixture
def bus() -> Iterator[CanopenBus]:
    settings = {"interface": "socketcan", "channel": new_interface(), "fault_cycles": FAULT_CYCLES}
    made = acquire(CanBus.model_validate(settings), 0.02)
    yield made
    release(made)


def link(bus: CanopenBus, state: str) -> None:
    subprocess.run(["ip", "link", "set", bus.settings.channel, state], check=True)


def test_the_kernel_stamps_frames_when_they_arrive(bus: CanopenBus) -> None:
    """Not when they are fetched: the age of a sample is true even after a late cycle."""
    heard: list[int] = []
    bus.route(0x183, lambda data, stamp: heard.append(stamp))
    bus.begin_cycle(time.monotonic_ns())
    with can.Bus(interface="socketcan", channel=bus.settings.channel) as other:
        before = time.monotonic_ns()
        other.send(can.Message(arbitration_id=0x183, is_extended_id=False, data=b"12345678"))
        after = time.monotonic_ns()
        time.sleep(0.1)  # the late cycle
        bus.begin_cycle(time.monotonic_ns())
    clock_grain_ns = 5_000_000  # of two clocks of a user-mode kernel
    assert before - clock_grain_ns < heard[0] < after + clock_grain_ns


def test_own_frames_do_not_come_back(bus: CanopenBus) -> None:
    for _ in range(3):
        bus.begin_cycle(time.monotonic_ns())
    assert (bus.frames, bus.foreign) == (0, 0)


def test_an_interface_that_goes_down_is_a_fault_with_the_kernels_words(bus: CanopenBus) -> None:
    bus.begin_cycle(time.monotonic_ns())
    link(bus, "down")
    for _ in range(FAULT_CYCLES):
        bus.begin_cycle(time.monotonic_ns())
    with pytest.raises(DriverError, match=r"(?i)network is down") as refusal:
        bus.begin_cycle(time.monotonic_ns())
    assert bus.settings.channel in str(refusal.value)
    link(bus, "up")
    with pytest.raises(DriverError):  # counts the last cycle without a bus
        bus.begin_cycle(time.monotonic_ns())
    failures = bus.send_failures
    for _ in range(3):
        bus.begin_cycle(time.monotonic_ns())
    assert bus.send_failures == failures


def test_an_interface_that_is_not_there_is_refused() -> None:
    with pytest.raises(DriverError, match="absent0"):
        acquire(CanBus.model_validate({"interface": "socketcan", "channel": "absent0"}), 0.02)
