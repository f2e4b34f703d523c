"""A hundred thousand requests, most of them nonsense, at the daemon's own methods with the loop behind them: all answered, none moves."""

from __future__ import annotations

import asyncio
import json
import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from daemon.server.socket_server import answer
from servo_control.signals import Mode
from tests.support.daemon.lockstep_requests import LockstepRequests, at_once
from tests.support.daemon.rigs import simple_rig

METHODS = (
    "status",
    "checks",
    "prove",
    "disarm",
    "reset",
    "start",
    "stream",
    "set_point",
    "stop",
    "estop",
    "maneuvers",
    "wait",
    "events",
    "shutdown",
)
STOP = b'{"v": 1, "id": 0, "method": "stop", "params": {}}\n'
ARMINGS = 0.01  # of the requests: each takes 250 cycles
KEYS = (
    "maneuver", "parameters", "shaper", "repeat", "approach", "countdown_s", "run", "timeout_s", "since", "pressure_is_off", "name", "text",
)  # fmt: skip
WORDS_OF_MANEUVERS = (
    "longreach:", "maneuver/1", "name:", "kind:", "straight_line", "joint:", "rotary", "-", "[]", "{}", ":", "1e999", "nan", "deg",
    "!!python/object", "&a", "*a", "\n",
)  # fmt: skip


class Client:
    """Requests by seed: bytes, JSON of any shape, and methods with parameters of every kind."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._texts = [self._text() for _ in range(1000)]

    def line(self) -> bytes:
        kind = self._random.random()
        if kind < 0.2:
            return self._random.randbytes(self._random.randrange(200)) + b"\n"
        if kind < 0.4:
            return json.dumps(self._value(3)).encode() + b"\n"
        method = "arm" if self._random.random() < ARMINGS else self._random.choice(METHODS)
        line = json.dumps({"v": 1, "id": self._value(1), "method": method, "params": self._parameters()}).encode() + b"\n"
        if kind < 0.5:  # one byte wrong
            place = self._random.randrange(len(line) - 1)
            line = line[:place] + self._random.randbytes(1).replace(b"\n", b" ") + line[place + 1 :]
        return line

    def _parameters(self) -> dict[str, Any]:
        return {self._random.choice(KEYS): self._value(3) for _ in range(self._random.choice((0, 0, 1, 2, 4)))}

    def _value(self, depth: int) -> Any:
        chance = self._random
        kind = chance.randrange(8 if depth else 6)
        if kind < 2:
            return chance.choice((None, True, False))
        if kind < 4:
            return chance.choice((chance.randint(-(2**70), 2**70), chance.uniform(-1e3, 1e3), float("inf"), float("nan")))
        if kind < 6:
            return chance.choice(self._texts)
        if kind == 6:
            return [self._value(depth - 1) for _ in range(chance.randrange(4))]
        return {chance.choice((*KEYS, *self._texts[:20])): self._value(depth - 1) for _ in range(chance.randrange(4))}

    def _text(self) -> str:
        chance = self._random
        if chance.random() < 0.3:
            return " ".join(chance.choices(WORDS_OF_MANEUVERS, k=chance.randrange(1, 6)))
        return "".join(chr(chance.randrange(1, chance.choice((128, 0x2FF)))) for _ in range(chance.randrange(12)))


def fuzz(directory: Path, monkeypatch: pytest.MonkeyPatch, requests: int) -> None:
    monkeypatch.setattr("daemon.server.request_handlers.asyncio.sleep", at_once)
    with simple_rig(directory) as (rig, device):
        lockstep, before = LockstepRequests(rig), dict(device.positions)
        seen, answers = asyncio.run(ask(lockstep, Client(seed=7), requests))
        assert device.positions == pytest.approx(before, abs=0.01), "hundreds of times armed, and held"
    assert not seen & {Mode.RUNNING, Mode.STOPPING, Mode.PROVING}
    assert seen >= {Mode.DISARMED, Mode.HOLDING, Mode.FAULT}
    assert answers["result"] > 0.05 * requests, "some of them mean something"
    assert lockstep.shutdowns > 0


async def ask(lockstep: LockstepRequests, client: Client, requests: int) -> tuple[set[Mode], Counter[str]]:
    """The modes that were seen, and how many requests were answered with what."""
    seen, answers = set(), Counter[str]()
    for _ in range(requests):
        reply = json.loads(await answer(client.line(), lockstep.handlers.methods))
        answers.update(set(reply) & {"result", "error"})
        assert "internal error" not in reply.get("error", {}).get("what", ""), reply
        if "countdown_s" in (reply.get("result") or {}):  # announced: taken back, or a `wait` would wait for its end
            await answer(STOP, lockstep.handlers.methods)
        seen.add(lockstep.rig.mode)
    assert answers.total() == requests
    return seen, answers


@pytest.mark.slow
def test_two_thousand_requests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fuzz(tmp_path, monkeypatch, 2_000)


@pytest.mark.slow
def test_a_hundred_thousand_requests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fuzz(tmp_path, monkeypatch, 100_000)
