"""A hundred thousand frames that no device sent, at the running loop over a virtual bus: it goes on, and no valve opens.

Frames that only devices take (their SDO requests, set points, NMT, SYNC) are left out: a second master is not an input of the daemon.
"""

from __future__ import annotations

import random
import time
from pathlib import Path

import can
import pytest

from config.options.canopen_rig import canopen_devices
from daemon.modes.mode_machine import OperatorAction
from drivers.canopen.bus import MOST_FRAMES
from servo_control.signals import Mode
from tests.support.daemon.can_daemon import CanDaemon, can_daemon
from tests.support.daemon.running_daemon import until

FRAMES = 100_000
BURST = MOST_FRAMES // 2  # a cycle
UNPROVEN = [f"devices.{name}.demand_proof=false" for name in ("rotary_valve", "io")]
BOOT_UP = b"\0"


class Stranger:
    """A node that sends anything under the identifiers of everybody."""

    def __init__(self, daemon: CanDaemon, seed: int) -> None:
        nodes = [options.node for options in canopen_devices(daemon.rig).values()]
        self._daemon, self._random = daemon, random.Random(seed)
        self._heard = [base + node for node in nodes for base in (0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700)]
        taken = {0x000, 0x080, *(base + node for node in nodes for base in (0x200, 0x300, 0x400, 0x500, 0x600))}
        self._others = [cob_id for cob_id in range(0x800) if cob_id not in taken]
        self._bus = can.Bus(interface="virtual", channel=next(iter(canopen_devices(daemon.rig).values())).bus.channel)
        self.sent = 0

    def burst(self, restarts: bool = True) -> None:
        """As many frames as fit into a cycle, and a cycle for them."""
        cycle = self._daemon.value("cycle")
        for _ in range(BURST):
            self._bus.send(self._frame(restarts))
        self.sent += BURST
        until(lambda: self._daemon.value("cycle") > cycle, 20.0)

    def _frame(self, restarts: bool) -> can.Message:
        chance = self._random
        cob_id = chance.choice(self._heard if chance.random() < 0.9 else self._others)
        data = chance.randbytes(chance.choice((0, 1, 2, 4, 7, 8, 8, 8)))
        if not restarts and cob_id >> 7 == 0xE and data == BOOT_UP:
            data = b"\5"
        kind = chance.random()
        return can.Message(
            arbitration_id=cob_id,
            data=data,
            is_extended_id=kind < 0.02,
            is_remote_frame=0.02 <= kind < 0.04,
            timestamp=chance.choice((time.time(), 0.0, 4e9, -1.0)),
        )

    def close(self) -> None:
        self._bus.shutdown()


def positions(daemon: CanDaemon) -> tuple[float, ...]:
    """Where the arm truly is."""
    return tuple(daemon.twin.bench.feed.plant.true_position)


def lives(daemon: CanDaemon) -> None:
    cycle = daemon.value("cycle")
    until(lambda: daemon.value("cycle") > cycle + 5, 20.0)


def holds(daemon: CanDaemon) -> bool:
    """Asks for it whenever nothing stands in the way: on a busy machine a sample may be too old in the cycle that would arm."""
    if daemon.mode is Mode.DISARMED and all(check.passes(daemon.loop.values) for check in daemon.loop.keeper.checks):
        daemon.post(OperatorAction.ARM)
    return daemon.mode is Mode.HOLDING


def fuzz_disarmed(directory: Path, frames: int) -> None:
    with can_daemon(directory, UNPROVEN) as daemon:
        daemon.post(OperatorAction.RESET)
        until(lambda: daemon.mode is Mode.DISARMED and daemon.value("commands") == 1)
        stranger, before = Stranger(daemon, seed=31), positions(daemon)
        while stranger.sent < frames:
            stranger.burst(restarts=stranger.sent > 0.9 * frames)
            assert daemon.mode in (Mode.DISARMED, Mode.FAULT)
            assert daemon.twin.bench.device("rotary_valve").describe()["state"] != "ACTIVE"
        stranger.close()
        lives(daemon)
        assert positions(daemon) == pytest.approx(before, abs=1e-3)
        devices = canopen_devices(daemon.rig)
        channel = next(iter(devices.values())).bus.channel
        until(lambda: daemon.value(f"{channel}.foreign") > 0.02 * frames, 5.0)
        # The counts come once a second; that the frames were for our devices may come with the next.
        until(lambda: all(daemon.value(f"{device}.malformed") > 0 for device in devices), 5.0)


def test_five_thousand_frames_do_not_move_a_disarmed_arm(tmp_path: Path) -> None:
    fuzz_disarmed(tmp_path, 5_000)


@pytest.mark.slow
def test_a_hundred_thousand_frames_do_not_move_a_disarmed_arm(tmp_path: Path) -> None:
    fuzz_disarmed(tmp_path, FRAMES)


@pytest.mark.slow
def test_an_armed_arm_faults_before_forged_positions_have_moved_it(tmp_path: Path) -> None:
    """Forged positions are what the servo acts on until a check sees them: that is over within a few cycles."""
    with can_daemon(tmp_path, UNPROVEN) as daemon:
        stranger = Stranger(daemon, seed=32)
        for _ in range(10):
            daemon.post(OperatorAction.RESET)  # forged boot-ups and emergencies: every device is set up again
            until(lambda: daemon.mode is Mode.DISARMED, 30.0)
            lives(daemon)  # with new samples
            until(lambda: holds(daemon), 20.0)
            before = positions(daemon)
            until(lambda: stranger.burst(restarts=False) or daemon.mode is Mode.FAULT, 10.0)
            lives(daemon)
            assert daemon.mode is Mode.FAULT
            assert daemon.twin.bench.device("rotary_valve").describe()["state"] != "ACTIVE"
            moved = [abs(after - start) for after, start in zip(positions(daemon), before, strict=True)]
            assert moved[0] < 0.02, "rad"
            assert moved[1] < 0.02, "m"
        stranger.close()
