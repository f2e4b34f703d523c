"""Whatever comes off the bus: no driver crashes, no number that is not finite is GOOD, and no valve is told to move that was not.

The interface is scripted, so that a hundred thousand frames take seconds.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import can
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from config.errors import DriverError
from drivers.canopen import bus as bus_module
from drivers.canopen.encoder_406 import EncoderDriver
from drivers.canopen.io_401 import IoDriver
from drivers.canopen.valve_408 import ValveDriver
from drivers.contract import Quality
from tests.drivers.canopen.test_bus import ScriptedInterface
from tests.support.drivers.canopen_rig import encoder, io_module, valve

MS = 1_000_000
FRAMES_AN_EXAMPLE = 50
OURS = [0x000, 0x080, 0x083, 0x08B, 0x095, 0x183, 0x18B, 0x20B, 0x295, 0x315, 0x583, 0x603, 0x703, 0x70B, 0x715, 0x77F, 0x7FF]
CHANNELS = itertools.count()

frames = st.builds(
    dict,
    arbitration_id=st.one_of(st.sampled_from(OURS), st.integers(0, 0x7FF)),
    data=st.binary(max_size=8),
    is_extended_id=st.sampled_from([False] * 9 + [True]),
    is_remote_frame=st.sampled_from([False] * 19 + [True]),
    is_error_frame=st.sampled_from([False] * 19 + [True]),
    timestamp=st.one_of(st.floats(0, 4e9), st.sampled_from([0.0, -1.0, 1e15])),
)


@pytest.fixture
def interface(monkeypatch: pytest.MonkeyPatch) -> Iterator[ScriptedInterface]:
    """Every bus that is opened is this one."""
    scripted = ScriptedInterface()
    monkeypatch.setattr(bus_module, "open_can", lambda settings: scripted)
    yield scripted
    bus_module._shared.clear()


def life(interface: ScriptedInterface, script: list[dict[str, Any]], active: bool) -> None:
    """Three devices, set up long ago, hear the script, five frames a cycle; their commands are legal throughout."""
    interface.incoming.clear()
    interface.sent.clear()
    channel = f"fuzz {next(CHANNELS)}"
    devices: list[EncoderDriver | ValveDriver | IoDriver] = [encoder(channel, 3), valve(channel, 11), io_module(channel, 21)]
    for device in devices:
        device.open()
        device._configured = True
        if active and not isinstance(device, EncoderDriver):
            device._active = True
    now = 10**12
    for first in range(0, len(script), 5):
        interface.incoming.extend(can.Message(**frame) for frame in script[first : first + 5])
        now += MS
        for device in devices:
            one_cycle(device, now)
    check_told(interface.sent, active)
    for device in devices:
        device._bus = None
    bus_module._shared.clear()


def one_cycle(device: EncoderDriver | ValveDriver | IoDriver, now: int) -> None:
    """Only a DriverError may come out."""
    try:
        for sample in device.read(now):
            assert 0 <= sample.stamp_ns <= now
            assert sample.quality == Quality.BAD or math.isfinite(sample.raw)
        if device.outputs and device._active:
            device.write([0.25] * len(device.outputs), now)
    except DriverError:
        if not isinstance(device, EncoderDriver):
            device.safe()


def check_told(sent: list[tuple[int, bytes]], active: bool) -> None:
    for cob_id, data in sent:
        if cob_id == 0x20B:
            word, set_point = data[0] + 256 * data[1], data[2] + 256 * data[3]
            assert set_point in ((0, 4096) if active else (0,))
            assert not word & 0b1000  # never resets a fault in the loop
            assert active or not word & 0b0110
        if cob_id == 0x315:
            assert active or data == b"\0" * 8


def fuzz(interface: ScriptedInterface, examples: int) -> None:
    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck), database=None)
    @given(script=st.lists(frames, min_size=FRAMES_AN_EXAMPLE, max_size=FRAMES_AN_EXAMPLE), active=st.booleans())
    def run(script: list[dict[str, Any]], active: bool) -> None:
        life(interface, script, active)

    run()


@pytest.mark.slow
def test_ten_thousand_frames(interface: ScriptedInterface) -> None:
    fuzz(interface, 10_000 // FRAMES_AN_EXAMPLE)


@pytest.mark.slow
def test_a_hundred_thousand_frames(interface: ScriptedInterface) -> None:
    fuzz(interface, 100_000 // FRAMES_AN_EXAMPLE)
