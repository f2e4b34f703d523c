"""A node that answers the set-up wrongly in every way an answer can be wrong: configure() succeeds or refuses, nothing else."""

from __future__ import annotations

import itertools
import queue
import random
from collections.abc import Iterator
from contextlib import suppress

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.errors import DriverError
from drivers.canopen import bus as bus_module
from drivers.canopen import node_reader
from drivers.canopen.bus import CanopenBus
from drivers.canopen.sdo_upload import upload
from tests.support.drivers.canopen_rig import encoder, io_module, valve

NODE = 11
CHANNELS = itertools.count()


class LyingNode(can.BusABC):
    """Answers SDO requests from a store of what was written, `wrong` of them mangled; `answers` counts all."""

    def __init__(self, seed: int, wrong: float) -> None:
        super().__init__("lying")
        self._random, self._wrong = random.Random(seed), wrong
        self._waiting: queue.SimpleQueue[can.Message] = queue.SimpleQueue()
        self._store: dict[bytes, bytes] = {}
        self.answers = 0

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if msg.arbitration_id == 0x600 + NODE:
            self.answers += 1
            answer = self._answer(bytes(msg.data))
            for data in self._mangled(answer) if self._random.random() < self._wrong else [answer]:
                self._put(0x580 + NODE, data)
        elif msg.arbitration_id == 0:
            self._put(0x700 + NODE, bytes([{1: 5, 2: 4}.get(msg.data[0], 127)]))

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        with suppress(queue.Empty):
            return self._waiting.get(timeout=timeout or 1e-6), False
        return None, False

    def _put(self, cob_id: int, data: bytes) -> None:
        self._waiting.put(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False))

    def _answer(self, request: bytes) -> bytes:
        place, command = request[1:4], request[0]
        if command == 0x40:
            content = self._store.get(place, bytes(4))
            return bytes([0x43 | (4 - len(content)) << 2]) + place + content.ljust(4, b"\0")
        self._store[place] = request[4 : 8 - (command >> 2 & 3)]
        return b"\x60" + place + bytes(4)

    def _mangled(self, answer: bytes) -> list[bytes]:
        chance = self._random
        return chance.choice(
            (
                [chance.randbytes(8)],
                [chance.randbytes(chance.randrange(8))],
                [bytes([chance.randrange(256)]) + answer[1:]],
                [answer[:1] + chance.randbytes(3) + answer[4:]],
                [answer[:4] + chance.randbytes(4)],
                [b"\x80" + answer[1:4] + chance.randbytes(4)],
                [b"\x41" + answer[1:4] + chance.randbytes(4)],  # the beginning of a segmented answer
                [chance.randbytes(8), answer],
                [answer, answer],
            )
        )


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A node that does not answer is given up at once."""
    monkeypatch.setattr("canopen.sdo.SdoClient.RESPONSE_TIMEOUT", 0.01)
    monkeypatch.setattr(node_reader, "_LISTEN_S", 1e-3)
    monkeypatch.setattr("drivers.canopen.device._START_LIMIT_S", 0.05)
    yield
    bus_module._shared.clear()


def set_up(monkeypatch: pytest.MonkeyPatch, answers: int) -> None:
    given, outcomes = 0, {"configured": 0, "refused": 0}
    for seed in itertools.count():
        if given >= answers:
            break
        node = LyingNode(seed, wrong=(0.0, 0.02, 0.1, 1.0)[seed % 4])
        monkeypatch.setattr(bus_module, "open_can", lambda settings, node=node: node)
        device = (valve, encoder, io_module)[seed % 3](f"lying {next(CHANNELS)}", NODE)
        device.open()
        try:
            device.configure()
            outcomes["configured"] += 1
        except DriverError:
            outcomes["refused"] += 1
        given += node.answers
        device.close()
    assert min(outcomes.values()) > 0.1 * sum(outcomes.values()), outcomes


def test_six_hundred_answers_about_the_set_up(monkeypatch: pytest.MonkeyPatch) -> None:
    set_up(monkeypatch, 600)


@pytest.mark.slow
def test_a_hundred_thousand_answers_about_the_set_up(monkeypatch: pytest.MonkeyPatch) -> None:
    set_up(monkeypatch, 100_000)


@given(st.binary(max_size=8))
def test_any_answer_to_a_read_in_the_loop_is_bytes_or_a_refusal(answer: bytes) -> None:
    bus = CanopenBus.__new__(CanopenBus)
    bus._routes, bus.settings = {}, valve("upload", NODE)._options.bus
    bus.can_bus = LyingNode(0, 0.0)
    steps = upload(bus, NODE, 0x6401, 1, 1.0)
    next(steps)
    for wrong_or_right in (answer, b"\x4b\x01\x64\x01" + answer[:4].ljust(4, b"\0")):
        bus._routes.get(0x580 + NODE, lambda data, stamp: None)(bytearray(wrong_or_right), 0)
    with pytest.raises((StopIteration, DriverError)) as end:
        next(steps)
    assert not isinstance(end.value, StopIteration) or 1 <= len(end.value.value) <= 4
    assert 0x580 + NODE not in bus._routes
    bus.shutdown()
