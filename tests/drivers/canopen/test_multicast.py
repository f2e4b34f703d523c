"""The same drivers over udp_multicast, between two sockets: only ever in a network namespace whose multicast stays on loopback."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import can
import pytest

from config.errors import ConfigError
from config.options.canopen_options import CanBus
from config.options.multicast import EXAMPLE_GROUP
from drivers.canopen.bus import acquire, release

NAMESPACE = ["unshare", "--net", "sh", "-c"]
ROUTE = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"
ROOT = Path(__file__).parents[3]


def test_frames_cross_a_multicast_bus(multicast_channel: str) -> None:
    bus = acquire(CanBus.model_validate({"interface": "udp_multicast", "channel": multicast_channel}), 0.02)
    other = can.Bus(interface="udp_multicast", channel=multicast_channel)
    heard: list[tuple[bytes, int]] = []
    bus.route(0x183, lambda data, stamp: heard.append((bytes(data), stamp)))
    other.send(can.Message(arbitration_id=0x183, is_extended_id=False, data=b"position"))
    end = time.monotonic() + 2.0
    while not heard and time.monotonic() < end:
        bus.begin_cycle(time.monotonic_ns())
    assert heard[0][0] == b"position"
    assert 0 <= time.monotonic_ns() - heard[0][1] < 2e9
    assert {frame.arbitration_id for frame in iter(lambda: other.recv(0.1), None)} >= {0x080, 0x77F}
    other.shutdown()
    release(bus)


def test_a_bus_whose_frames_would_leave_is_never_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where they would stay this test has nothing to show, and is skipped."""
    way = subprocess.run(["ip", "-4", "route", "get", EXAMPLE_GROUP], capture_output=True, text=True, check=False).stdout
    if " dev lo " in way:
        pytest.skip("multicast stays on lo here")
    opened: list[object] = []
    monkeypatch.setattr(can, "Bus", lambda **options: opened.append(options))
    with pytest.raises(ConfigError, match=r"udp_multicast frames would leave this machine.*ip netns add"):
        acquire(CanBus.model_validate({"interface": "udp_multicast", "channel": EXAMPLE_GROUP}), 0.02)
    assert not opened


def test_a_channel_that_is_no_group_is_refused_by_name() -> None:
    with pytest.raises(ConfigError, match=r"no IPv4 group: can0"):
        acquire(CanBus.model_validate({"interface": "udp_multicast", "channel": "can0"}), 0.02)


def in_namespace(preparation: str, wanted: Callable[..., None]) -> str:
    """What pytest says about a test of this file in a namespace of its own."""
    test = f"{__file__}::{wanted.__name__}"
    command = f"{preparation} && {sys.executable} -m pytest -q -p no:cacheprovider {test}"
    try:
        done = subprocess.run([*NAMESPACE, command], capture_output=True, text=True, timeout=120, check=False, cwd=ROOT)
    except FileNotFoundError:
        pytest.skip("no `unshare` command")
    if "Operation not permitted" in done.stderr:
        pytest.skip("no right to make a network namespace")
    return done.stdout + done.stderr


@pytest.mark.slow
def test_in_a_namespace_with_a_route_on_loopback_frames_cross() -> None:
    assert "1 passed" in in_namespace(ROUTE, test_frames_cross_a_multicast_bus)


@pytest.mark.slow
def test_without_that_route_the_bus_is_never_opened() -> None:
    assert "1 passed" in in_namespace("ip link set lo up", test_a_bus_whose_frames_would_leave_is_never_opened)
