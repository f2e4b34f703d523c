"""A simulated CANopen device (CiA 301): NMT states, SDO server, PDOs on SYNC, heartbeat both ways, EMCY, error behaviour.

Profiles subclass it. Nothing here has a thread or a clock: the bench hands it frames and the time. canopen's LocalNode neither
consumes heartbeats nor answers SYNC, and its heartbeat needs a thread a node, so only its SDO server and dictionary are used.
"""

from __future__ import annotations

import struct
from collections import deque

from sim_backend.twin.can.dictionary import MAPPING, dictionary, pdo_records
from sim_backend.twin.can.heartbeats import CONSUMER, HeartbeatConsumer
from sim_backend.twin.can.object_store import ObjectStore, SdoPort, Send
from sim_backend.twin.can.pdo import PDO_IS_ON, Pdo
from sim_backend.twin.faults import NodeFaults

INITIALISING, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
START, STOP, ENTER_PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130
HEARTBEAT_LOST, RPDO_LATE, PDO_TOO_SHORT = 0x8130, 0x8250, 0x8210  # EMCY codes of CiA 301
_HEARTBEAT_ID = 0x700
_ERROR_BEHAVIOUR = {0: PRE_OPERATIONAL, 2: STOPPED}  # 0x1029:1; 1 changes nothing
_STATE_NAMES = {INITIALISING: "initialising", STOPPED: "stopped", OPERATIONAL: "operational", PRE_OPERATIONAL: "pre-operational"}
_COMMANDED = {START: OPERATIONAL, STOP: STOPPED, ENTER_PRE_OPERATIONAL: PRE_OPERATIONAL}


class CanNode:
    """One device. `name` is the rig's name of it; `faults` is what is wrong with it."""

    profile = ""

    def __init__(self, name: str, node: int, send: Send) -> None:
        self.name = name
        self.node = node
        self.state = INITIALISING
        self.faults = NodeFaults()
        self.store = ObjectStore(dictionary(self.profile, node), self._guard, self._written)
        self._wire = send
        self._sdo = SdoPort(node, self.store, self._send)
        self._heartbeats = HeartbeatConsumer(self.store)
        self._pdos = [Pdo(self.store, index) for index in pdo_records(self.store.object_dictionary)]
        self._receive = [pdo for pdo in self._pdos if not pdo.is_transmit]
        self._transmit = [pdo for pdo in self._pdos if pdo.is_transmit]
        self._rpdo_heard_ns: dict[int, int] = {}
        self._tpdo_sent_ns: dict[int, int] = {}
        self._syncs = 0
        self._heartbeat_due_ns = 0
        self._delayed: deque[tuple[int, int, bytes]] = deque()
        self._restarts = False
        self.longest_pause_ns = 0  # between two receive PDOs, since clear()

    def start(self, now_ns: int) -> None:
        """Power on (or reset): defaults, boot-up message, then pre-operational."""
        self.state = INITIALISING
        self.store.restore_defaults()
        self._refresh()
        self._rpdo_heard_ns.clear()
        self.powered_on()
        self._send(_HEARTBEAT_ID + self.node, b"\0")
        self.state = PRE_OPERATIONAL
        self._heartbeat_due_ns = now_ns

    def on_nmt(self, data: bytes, now_ns: int) -> None:
        """The NMT master's command to this node or to all."""
        if self.faults.silent or len(data) < 2 or data[1] not in (0, self.node):
            return
        if data[0] in (RESET_NODE, RESET_COMMUNICATION):
            self.start(now_ns)
        elif data[0] in _COMMANDED:
            self._enter(_COMMANDED[data[0]])

    def on_sync(self, now_ns: int) -> None:
        """Send the process data that are due at this SYNC."""
        if self.faults.silent or self.state != OPERATIONAL:
            return
        self._syncs += 1
        for pdo in self._transmit:
            if pdo.is_on and pdo.every_syncs and self._syncs % pdo.every_syncs == 0:
                self._send_pdo(pdo, now_ns)

    def on_frame(self, cob_id: int, data: bytes, now_ns: int) -> None:
        """Any other frame: SDO request, process data, somebody's heartbeat."""
        if self.faults.silent:
            return
        if cob_id == self._sdo.request_cob_id:
            if self.state in (PRE_OPERATIONAL, OPERATIONAL):
                self._sdo.on_request(data)
        elif cob_id > _HEARTBEAT_ID:
            self._heartbeats.heard(cob_id - _HEARTBEAT_ID, now_ns)
        elif self.state == OPERATIONAL:
            self._on_process_data(cob_id, data, now_ns)

    def tick(self, now_ns: int) -> None:
        """Whatever time alone brings: heartbeats, time-outs, delayed and cyclic process data."""
        if self._restarts:
            self._restarts = False
            self.start(now_ns)
        self._beat(now_ns)
        while self._delayed and self._delayed[0][0] <= now_ns:
            _, cob_id, data = self._delayed.popleft()
            self._send(cob_id, data)
        for _ in self._heartbeats.lost(now_ns):
            self._communication_error(HEARTBEAT_LOST)
        self._watch_process_data(now_ns)

    def emergency(self, code: int, register: int = 0x01) -> None:
        """Send EMCY and note the error; code 0 says that all is well again."""
        self.store.values[0x1001, 0] = register if code else 0
        self._send(0x80 + self.node, struct.pack("<HB5x", code, register if code else 0))

    def inject(self, fault: str, amount: float) -> None:
        """Start a fault by name (see faults.EFFECTS; also `emcy` with the code, `leave` for falling out of OPERATIONAL, `restart`)."""
        if fault == "emcy":
            self.emergency(int(amount) or 0x1000)
        elif fault == "leave":
            self._enter(PRE_OPERATIONAL)
        elif fault == "restart":
            self._restarts = True
        else:
            self.faults.set(fault, amount)

    def clear(self) -> None:
        """Everything is right again. What the fault has led to (an NMT state, a device fault) stays."""
        self.faults = NodeFaults()
        self.longest_pause_ns = 0

    def powered_on(self) -> None:
        """For profiles: the device's own state after power-on."""

    def received(self) -> None:
        """For profiles: process data have come."""

    def object_written(self, index: int) -> None:
        """For profiles: an SDO has changed a value."""

    def communication_lost(self, code: int) -> None:
        """For profiles: the master is silent (EMCY code says how)."""

    def left_operational(self) -> None:
        """For profiles: no process data can arrive any more."""

    def describe(self) -> dict[str, float | str]:
        """State for a person or a test in another process."""
        return {"nmt": _STATE_NAMES[self.state], "longest_pause_ns": self.longest_pause_ns}

    def _communication_error(self, code: int) -> None:
        self.emergency(code, 0x11)
        self.communication_lost(code)
        if self.state == OPERATIONAL:
            self._enter(_ERROR_BEHAVIOUR.get(self.store.values[0x1029, 1], self.state))

    def _enter(self, state: int) -> None:
        was_operational = self.state == OPERATIONAL
        self.state = state
        self._syncs = 0
        self._rpdo_heard_ns.clear()
        if was_operational and state != OPERATIONAL:
            self.left_operational()

    def _on_process_data(self, cob_id: int, data: bytes, now_ns: int) -> None:
        for pdo in self._receive:
            if not pdo.is_on or pdo.cob_id != cob_id:
                continue
            if not pdo.unpack(data):
                self.emergency(PDO_TOO_SHORT, 0x11)
                continue
            pause_ns = now_ns - self._rpdo_heard_ns.get(pdo.communication, now_ns)
            self.longest_pause_ns = max(self.longest_pause_ns, pause_ns)
            self._rpdo_heard_ns[pdo.communication] = now_ns
            self.received()

    def _watch_process_data(self, now_ns: int) -> None:
        for pdo in self._receive:
            heard = self._rpdo_heard_ns.get(pdo.communication)
            if pdo.event_timer_ns and heard is not None and now_ns - heard > pdo.event_timer_ns:
                del self._rpdo_heard_ns[pdo.communication]
                self._communication_error(RPDO_LATE)
        for pdo in self._transmit:
            is_cyclic = pdo.is_on and not pdo.every_syncs and pdo.event_timer_ns
            if is_cyclic and self.state == OPERATIONAL and now_ns - self._tpdo_sent_ns.get(pdo.communication, 0) >= pdo.event_timer_ns:
                self._send_pdo(pdo, now_ns)

    def _beat(self, now_ns: int) -> None:
        period_ms = self.store.values[0x1017, 0]
        if not period_ms or now_ns < self._heartbeat_due_ns:
            return
        self._heartbeat_due_ns = max(self._heartbeat_due_ns + period_ms * 1_000_000, now_ns)
        if not self.faults.no_heartbeat:
            self._send(_HEARTBEAT_ID + self.node, bytes([self.state]))

    def _send_pdo(self, pdo: Pdo, now_ns: int) -> None:
        self._tpdo_sent_ns[pdo.communication] = now_ns
        if self.faults.late_ns:
            self._delayed.append((now_ns + self.faults.late_ns, pdo.cob_id, pdo.pack()))
        else:
            self._send(pdo.cob_id, pdo.pack())

    def _send(self, cob_id: int, data: bytes) -> None:
        if not self.faults.silent:
            self._wire(cob_id, data)

    def _guard(self, index: int, subindex: int, value: int) -> int | None:
        for pdo in self._pdos:
            if index == pdo.mapping:
                return pdo.refuses(subindex, value)
            if index == pdo.communication and subindex == 1 and pdo.is_on and value & 0x7FF != pdo.cob_id:
                return PDO_IS_ON  # CiA 301: the COB-ID of a PDO in use does not change
        return None

    def _written(self, index: int, subindex: int) -> None:
        if index == CONSUMER or any(index in (pdo.communication, pdo.communication + MAPPING) for pdo in self._pdos):
            self._refresh()
        self.object_written(index)

    def _refresh(self) -> None:
        for pdo in self._pdos:
            pdo.refresh()
        self._heartbeats.refresh()
