"""Late and lost frames told apart, and nothing old used uncounted: the real driver on a bus whose time and delays the test makes.

The content of every frame is the number of the SYNC it answers, so what is truly late, lost or old is known without any count.
"""

from __future__ import annotations

import random
import struct
from collections import deque
from collections.abc import Callable
from types import SimpleNamespace

import can
import pytest

from drivers.canopen import bus as bus_module
from drivers.canopen.encoder_406 import EncoderDriver
from drivers.canopen.frame_count import FrameCount
from tests.support.drivers.canopen_rig import encoder

MS = 1_000_000
ANSWER_NS = MS // 5
PATIENCE = 6
DROPPED = -1


class SlowEncoder(can.BusABC):
    """Answers SYNC number n after ANSWER_NS and `delay(n)` cycles, in order; not at all when that is DROPPED."""

    def __init__(self, delay: Callable[[int], int]) -> None:
        super().__init__("slow encoder")
        self.now_ns = 0
        self.syncs = 0
        self.dropped: list[int] = []
        self._delay = delay
        self._waiting: deque[tuple[int, int]] = deque()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if msg.arbitration_id != 0x080:
            return
        delay, last_ns = self._delay(self.syncs), self._waiting[-1][0] if self._waiting else 0
        if delay == DROPPED:
            self.dropped.append(self.syncs)
        else:
            self._waiting.append((max(last_ns, self.now_ns + ANSWER_NS + delay * MS), self.syncs))
        self.syncs += 1

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._waiting or self._waiting[0][0] > self.now_ns:
            return None, False
        arrived_ns, number = self._waiting.popleft()
        data = struct.pack("<IhH", number, 0, 0)
        return can.Message(arbitration_id=0x183, is_extended_id=False, data=data, timestamp=arrived_ns * 1e-9), False


class Watched:
    """What a run of cycles truly used."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, delay: Callable[[int], int]) -> None:
        self.bus = SlowEncoder(delay)
        monkeypatch.setattr(bus_module, "open_can", lambda settings: self.bus)
        clock = SimpleNamespace(time_ns=lambda: self.bus.now_ns, monotonic_ns=lambda: self.bus.now_ns)
        monkeypatch.setattr(bus_module, "time", clock)
        self.driver: EncoderDriver = encoder("slow encoder", 3, missing_frames=PATIENCE)
        self.driver.open()
        self.late: set[int] = set()
        self.old_cycles = 0

    def run(self, cycles: int) -> None:
        """The loop's cycles, 1 ms apart; SYNC n is sent in cycle n and due in cycle n + 1."""
        before = -1
        for cycle in range(cycles):
            self.bus.now_ns = (cycle + 1) * MS
            sample = self.driver.read(self.bus.now_ns)[0]
            newest = int(sample.raw) if sample.raw == sample.raw else -1
            arrived = [number for number in range(before + 1, newest + 1) if number not in self.bus.dropped]
            self.late |= {number for number in arrived if number < cycle - 1}
            before = newest
            age_ns = self.bus.now_ns - sample.stamp_ns
            self.old_cycles += age_ns > 2 * MS

    def close(self) -> None:
        self.driver.close()


def scripted(events: dict[int, int]) -> Callable[[int], int]:
    return lambda number: events.get(number, 0)


@pytest.mark.parametrize(
    ("events", "late", "lost"),
    [
        ({}, 0, 0),
        ({20: DROPPED}, 0, 1),
        ({20: 1}, 1, 0),
        ({20: 3}, 3, 0),  # the two behind it wait for it
        ({20: DROPPED, 21: DROPPED}, 0, 2),
        ({20: 1, 40: DROPPED, 60: 2}, 3, 1),
        ({20: 2, 21: 2, 22: 2, 23: 2}, 5, 0),  # late for a while: 24 waits for 23
        ({20: DROPPED, 21: 1}, 1, 1),
    ],
)
def test_late_is_not_lost(monkeypatch: pytest.MonkeyPatch, events: dict[int, int], late: int, lost: int) -> None:
    watched = Watched(monkeypatch, scripted(events))
    watched.run(100)
    assert (watched.driver.late, watched.driver.lost) == (late, lost)
    assert (len(watched.late), len(watched.bus.dropped)) == (late, lost), "the test's own account"
    assert watched.driver.stale == watched.old_cycles
    watched.close()


@pytest.mark.parametrize("seed", range(20))
def test_whatever_comes_late_or_never_is_counted_and_every_old_value_is(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    """Episodes of either kind, a while apart, at random."""
    chance, events, number = random.Random(seed), {}, 10
    while number < 950:
        length = chance.randint(1, 3)
        delay = chance.choice((DROPPED, 1, 2, 3))
        events |= dict.fromkeys(range(number, number + length), delay)
        number += length + PATIENCE + 4 + chance.randint(0, 20)
    watched = Watched(monkeypatch, scripted(events))
    watched.run(1000)
    assert watched.driver.late == len(watched.late) > 0
    assert watched.driver.lost == len(watched.bus.dropped) > 0
    assert watched.driver.stale == watched.old_cycles > 0
    watched.close()


@pytest.mark.parametrize("seed", range(20))
def test_no_frame_is_forgotten_however_bad_the_bus(seed: int) -> None:
    """Due = received + lost + still owed, as long as nothing is later than the device may be silent for."""
    chance, count = random.Random(seed), FrameCount(1, PATIENCE)
    count.cycle(1)
    due, received = 0, 0
    backlog = 0
    for cycle in range(2000):
        due += 1
        backlog += chance.random() < 0.9
        came = backlog if cycle % (PATIENCE // 2) == 0 else chance.randint(0, backlog)
        backlog -= came
        received += came
        count.cycle(came)
        assert due - received - count.lost >= 0
        assert count.late <= received
    for _ in range(PATIENCE + 1):
        due, received = due + 1, received + 1
        count.cycle(1)
    assert due == received + count.lost


def test_a_device_that_is_gone_loses_every_frame() -> None:
    count = FrameCount(1, PATIENCE)
    count.cycle(1)
    for _ in range(100):
        count.cycle(0)
    assert (count.lost, count.late) == (100 - PATIENCE, 0), "the last ones may still come"


def test_a_frame_between_two_that_are_due_is_late_at_once() -> None:
    """One frame at every tenth SYNC: the eleventh cycle brings the one of the tenth."""
    count = FrameCount(10, 3)
    for cycle in range(1, 41):
        count.cycle(cycle in (10, 21, 30, 40))
    assert (count.late, count.lost) == (1, 0)


def test_nothing_is_owed_before_the_first_frame_nor_after_a_restart() -> None:
    count = FrameCount(1, 3)
    for came in (0, 0, 0, 0, 0, 1, 0):
        count.cycle(came)
    count.restart()
    for _ in range(10):
        count.cycle(1)
    assert (count.late, count.lost) == (0, 0)
