"""Heartbeat consumer of a simulated device (object 0x1016): who is watched, and who has been silent for too long."""

from __future__ import annotations

from sim_backend.twin.can.object_store import ObjectStore

CONSUMER = 0x1016


class HeartbeatConsumer:
    """Watching a node begins with its first heartbeat (CiA 301), so that a device does not fault before its master has started."""

    def __init__(self, store: ObjectStore) -> None:
        self._store = store
        self._watched_ns: dict[int, int] = {}  # node → longest silence
        self._heard_ns: dict[int, int] = {}

    def refresh(self) -> None:
        """Read the set-up again. An entry with node 0 or time 0 is off; changing an entry starts its watch anew."""
        entries = [value for (index, sub), value in self._store.values.items() if index == CONSUMER and sub > 0]
        watched = {value >> 16 & 0x7F: (value & 0xFFFF) * 1_000_000 for value in entries}
        watched = {node: silence_ns for node, silence_ns in watched.items() if node and silence_ns}
        self._heard_ns = {node: heard for node, heard in self._heard_ns.items() if watched.get(node) == self._watched_ns.get(node)}
        self._watched_ns = watched

    def heard(self, node: int, now_ns: int) -> None:
        if node in self._watched_ns:
            self._heard_ns[node] = now_ns

    def lost(self, now_ns: int) -> list[int]:
        """Nodes whose heartbeat has just been missed; each is told once, until it is heard again."""
        if not self._heard_ns:
            return []
        lost = [node for node, heard in self._heard_ns.items() if now_ns - heard > self._watched_ns[node]]
        for node in lost:
            del self._heard_ns[node]
        return lost
