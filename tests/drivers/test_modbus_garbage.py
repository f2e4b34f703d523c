"""A TCP peer that is no Modbus device: random bytes, right headers with wrong contents, halves of answers. Read as BAD, and in time."""

from __future__ import annotations

import random
import socket
import socketserver
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import suppress

import pytest

from config.options.driver_options import device_options
from config.schema.rig import Device
from drivers.contract import Quality
from drivers.modbus import ModbusDriver

ANSWER_S = 0.02
REGISTERS = 4


class Peer(socketserver.ThreadingTCPServer):
    """Answers the first question of every connection rightly while `is_right`, and otherwise with what the seed brings."""

    allow_reuse_address = daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Conversation)
        self.chance = random.Random(3)
        self.is_right = True
        self.answers = 0


class Conversation(socketserver.BaseRequestHandler):
    server: Peer

    def handle(self) -> None:
        with suppress(OSError):
            while question := self.request.recv(64):
                self.server.answers += 1
                self.request.sendall(self._answer(question))

    def _answer(self, question: bytes) -> bytes:
        right = question[:4] + struct.pack(">HBBB", 3 + 2 * REGISTERS, question[6], question[7], 2 * REGISTERS) + bytes(2 * REGISTERS)
        chance = self.server.chance
        if self.server.is_right:
            return right
        return chance.choice(
            (
                chance.randbytes(chance.randrange(1, 40)),
                right[: chance.randrange(1, len(right))],
                question[:4] + struct.pack(">H", chance.randrange(65536)) + chance.randbytes(chance.randrange(1, 30)),
                right[:8] + chance.randbytes(1) + right[9:],
                chance.randbytes(2) + right[2:],
                right[:7] + bytes([question[7] | 0x80, chance.randrange(256)]),
                right + chance.randbytes(chance.randrange(1, 20)),
            )
        )


@pytest.fixture
def peer() -> Iterator[Peer]:
    with Peer() as server:
        threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True).start()
        yield server
        server.shutdown()


def fuzz(peer: Peer, answers: int) -> None:
    options = {
        "transport": "tcp",
        "host": "127.0.0.1",
        "port": peer.server_address[1],
        "answer_timeout": f"{ANSWER_S} s",
        "retry_after": "10 ms",
    }
    channels = {f"c{address}": {"address": address} for address in range(REGISTERS)}
    driver = ModbusDriver("gauges", device_options("gauges", Device(driver="modbus", slow=True, options={**options, "channels": channels})))
    driver.open()
    driver.configure()
    assert {sample.quality for sample in driver.read(time.monotonic_ns())} == {Quality.GOOD}
    peer.is_right = False
    while peer.answers < answers:
        for sample in driver.read(time.monotonic_ns()):
            assert (sample.raw == sample.raw) == (sample.quality == Quality.GOOD)
            assert sample.quality == Quality.BAD or -32768 <= sample.raw <= 32767
    assert driver.failures > 0.5 * answers
    peer.is_right = True
    end = time.monotonic() + 10.0
    while {sample.quality for sample in driver.read(time.monotonic_ns())} != {Quality.GOOD}:
        assert time.monotonic() < end, "it does not come back"
    driver.close()


@pytest.mark.device_clock
def test_forty_wrong_answers(peer: Peer) -> None:
    fuzz(peer, 40)


@pytest.mark.slow
def test_five_hundred_wrong_answers(peer: Peer) -> None:
    fuzz(peer, 500)


def test_the_peer_speaks_modbus_when_it_is_right(peer: Peer) -> None:
    """By hand: function 4, four registers (Modbus application protocol V1.1b3, 6.4)."""
    with socket.create_connection(peer.server_address) as connection:
        connection.sendall(bytes.fromhex("0007 0000 0006 01 04 0000 0004"))
        assert connection.recv(64) == bytes.fromhex("0007 0000 000b 01 04 08 0000 0000 0000 0000")
