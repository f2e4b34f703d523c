"""CANopen devices for tests, made of the canopen package's LocalNode and the shipped EDS files; independent of the hardware twin.

One thread a bench reads the bus, answers SYNC and watches heartbeats. `settle()` returns when everything sent so far is handled.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
import canopen

import config

EDS = Path(config.__file__).parent / "eds"
PRE_OPERATIONAL, OPERATIONAL = "PRE-OPERATIONAL", "OPERATIONAL"
_MARKER = 0x7FF

UP = {"INIT": ("DISABLED", 0b001), "DISABLED": ("HOLD", 0b011), "HOLD": ("ACTIVE", 0b111)}
DOWN = {"ACTIVE": ("HOLD", 0b100), "HOLD": ("DISABLED", 0b010), "DISABLED": ("INIT", 0b001)}
BITS = {
    "INIT": 0b1000, "DISABLED": 0b1001, "HOLD": 0b1011, "ACTIVE": 0b1111,
    "FAULT_INIT": 0b0000, "FAULT_DISABLED": 0b0001, "FAULT_HOLD": 0b0011, "FAULT_REACTION": 0b0111,
}  # fmt: skip
AFTER_RESET = {"FAULT_INIT": "INIT", "FAULT_DISABLED": "DISABLED", "FAULT_HOLD": "HOLD"}


class NodeBench:
    """A virtual bus with nodes on it."""

    def __init__(self, channel: str) -> None:
        self.channel = channel
        self.bus = can.Bus(interface="virtual", channel=channel)
        self.network = canopen.Network(self.bus)
        self.nodes: list[TestNode] = []
        self._settled = threading.Event()
        self._running = True
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> NodeBench:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._running = False
        self._thread.join()
        for node in self.nodes:
            node.local.nmt.stop_heartbeat()
        self.bus.shutdown()

    def settle(self) -> None:
        """Wait until the nodes have handled all frames sent so far."""
        self._settled.clear()
        self.bus.queue.put(can.Message(arbitration_id=_MARKER))
        assert self._settled.wait(2.0)

    def wait_for(self, condition: Callable[[], bool], limit_s: float = 2.0) -> None:
        end = time.monotonic() + limit_s
        while not condition():
            assert time.monotonic() < end, "the condition did not come true"
            self.settle()

    def _run(self) -> None:
        while self._running:
            message = self.bus.recv(0.001)
            now = time.monotonic()
            if message is not None and message.arbitration_id == _MARKER:
                self._settled.set()
            elif message is not None:
                self.network.notify(message.arbitration_id, message.data, message.timestamp)
            for node in self.nodes:
                node.watch(now)


class TestNode:
    """LocalNode, and what it lacks: answers to SYNC, a heartbeat consumer, a deadline for receive PDOs."""

    __test__ = False
    eds = ""
    rpdo = 0

    def __init__(self, bench: NodeBench, number: int) -> None:
        self.bench = bench
        self.number = number
        self.local = canopen.LocalNode(number, str(EDS / f"{self.eds}.eds"))
        self.silent = False
        self.syncs = 0
        self.heard_master: float | None = None
        self.heard_set_point: float | None = None
        self.cut_off = ""
        network = bench.network
        network.add_node(self.local)
        network.subscribe(0x000, self._on_nmt)
        network.subscribe(0x080, self._on_sync)
        network.subscribe(0x700 + 127, self._on_heartbeat)
        self.local.nmt.state = "INITIALISING"
        self.local.nmt.state = PRE_OPERATIONAL
        bench.nodes.append(self)

    @property
    def state(self) -> str:
        return str(self.local.nmt.state)

    def get(self, index: int, sub: int = 0) -> int:
        """Past every protocol: the value in the node's object dictionary."""
        variable = self.local.sdo[index]
        return int((variable[sub] if sub else variable).raw)

    def put(self, index: int, sub: int, value: int) -> None:
        variable = self.local.sdo[index]
        (variable[sub] if sub else variable).raw = value

    def send(self, cob_id: int, data: bytes) -> None:
        self.bench.network.send_message(cob_id, data)

    def watch(self, now: float) -> None:
        """Time-outs of a running node."""
        if self.state != OPERATIONAL:
            return
        consumer_ms = self.get(0x1016, 1) & 0xFFFF
        if consumer_ms and self.heard_master is not None and now - self.heard_master > consumer_ms / 1e3:
            self.heard_master = None
            self._lost("heartbeat", 0x8130)
        deadline_ms = self.get(0x1400 + self.rpdo - 1, 5) if self.rpdo else 0
        if deadline_ms and self.heard_set_point is not None and now - self.heard_set_point > deadline_ms / 1e3:
            self.heard_set_point = None
            self._lost("set points", 0x8250)

    def on_sync(self, tpdo: Any) -> None:
        """For subclasses: put the process data into the map; it is sent afterwards."""

    def on_process_data(self, rpdo: Any) -> None:
        """For subclasses: a receive PDO has come."""

    def on_communication_lost(self) -> None:
        """For subclasses."""

    def _lost(self, what: str, code: int) -> None:
        self.cut_off = what
        self.on_communication_lost()
        if not self.silent:
            self.local.emcy.send(code, 0x11)
        if self.get(0x1029, 1) == 0:
            self.local.nmt.state = PRE_OPERATIONAL

    def _on_nmt(self, cob_id: int, data: bytearray, stamp: float) -> None:
        if data[1] not in (0, self.number) or data[0] != 1:
            return
        self.heard_set_point = None
        self.local.tpdo.read()
        self.local.rpdo.read()
        if self.rpdo:
            rpdo = self.local.rpdo[self.rpdo]
            rpdo.callbacks = [self._on_rpdo]

    def _on_rpdo(self, rpdo: Any) -> None:
        if self.state == OPERATIONAL and not self.silent:
            self.heard_set_point = time.monotonic()
            self.on_process_data(rpdo)

    def _on_sync(self, cob_id: int, data: bytearray, stamp: float) -> None:
        if self.state != OPERATIONAL or self.silent:
            return
        self.syncs += 1
        for number in self.local.tpdo:
            tpdo = self.local.tpdo[number]
            if tpdo.enabled and 1 <= tpdo.trans_type <= 240 and self.syncs % tpdo.trans_type == 0:
                self.on_sync(tpdo)
                tpdo.transmit()

    def _on_heartbeat(self, cob_id: int, data: bytearray, stamp: float) -> None:
        self.heard_master = time.monotonic()


class EncoderNode(TestNode):
    eds = "encoder_406"

    def __init__(self, bench: NodeBench, number: int) -> None:
        self.position, self.speed, self.alarms = 0, 0, 0
        super().__init__(bench, number)

    def on_sync(self, tpdo: Any) -> None:
        for variable, value in zip(tpdo.map, (self.position, self.speed, self.alarms), strict=True):
            variable.raw = value


class ValveNode(TestNode):
    """States by Moog's diagram, written down as the words that lead up and down; the spool arrives at once."""

    eds = "valve_408"
    rpdo = 1
    FAILSAFE, STICKING = 0, 4321

    def __init__(self, bench: NodeBench, number: int) -> None:
        self.device_state = "INIT"
        self.word = self.set_point = 0
        self.stuck = self.no_reset = False
        self.sticky_spool = False
        self.words: list[int] = []
        super().__init__(bench, number)

    @property
    def spool(self) -> int:
        if self.sticky_spool:
            return self.STICKING
        if self.device_state == "ACTIVE":
            return self.set_point
        return self.get(0x6314, 1) if self.device_state in ("HOLD", "FAULT_HOLD") else self.FAILSAFE

    def on_process_data(self, rpdo: Any) -> None:
        word, self.set_point = rpdo.map[0].raw, rpdo.map[1].raw
        self.words.append(word)
        self.obey(word)

    def obey(self, word: int) -> None:
        old, self.word = self.word, word
        if self.stuck:
            return
        if self.device_state in AFTER_RESET:
            if word & 8 and not old & 8 and not self.no_reset:
                self.device_state = AFTER_RESET[self.device_state]
            return
        above, bits = UP.get(self.device_state, ("", 0b1111))
        if word & bits == bits:
            self.device_state = above
            return
        while self.device_state in DOWN and not word & DOWN[self.device_state][1]:
            self.device_state = DOWN[self.device_state][0]

    def on_communication_lost(self) -> None:
        reaction = self.get(0x2830, {"heartbeat": 75, "set points": 77}[self.cut_off])
        self.device_state = {2: "FAULT_DISABLED", 3: "FAULT_HOLD"}.get(reaction, self.device_state)

    def on_sync(self, tpdo: Any) -> None:
        tpdo.map[0].raw = BITS[self.device_state]
        tpdo.map[1].raw = self.spool


class IoNode(TestNode):
    eds = "io_401"
    rpdo = 2

    def __init__(self, bench: NodeBench, number: int) -> None:
        self.written = [0] * 4
        self.inputs = [0] * 4
        self.wired: dict[int, int] = {}
        super().__init__(bench, number)

    @property
    def terminals(self) -> list[int]:
        if self.state == OPERATIONAL:
            return self.written
        return [self.get(0x6444, sub) if self.get(0x6443, sub) == 1 else self.written[sub - 1] for sub in range(1, 5)]

    def watch(self, now: float) -> None:
        super().watch(now)
        for output, channel in self.wired.items():
            self.put(0x6401, channel, self.terminals[output - 1])

    def on_process_data(self, rpdo: Any) -> None:
        for number, variable in enumerate(rpdo.map):
            self.written[number] = variable.raw

    def on_sync(self, tpdo: Any) -> None:
        for channel, variable in enumerate(tpdo.map, 1):
            variable.raw = self.get(0x6401, channel) if self.wired else self.inputs[channel - 1]
