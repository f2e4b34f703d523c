"""Every piece of memory the daemon's processes share, made by the supervisor and handed to each child by descriptor.

A child must start fast: only who makes the memory, or asks for the rig, imports what a rig needs.
"""

from __future__ import annotations

import pickle
import time
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, NamedTuple, cast

from daemon.cycle.timing import WORDS
from daemon.ipc.mailbox import Mailbox
from daemon.ipc.ring import Ring, stored_bytes
from daemon.ipc.shared_memory import SharedMemory
from daemon.loop.set_points import SetPointBox, set_point_mailbox
from daemon.server.loop_silence import SILENT_S

if TYPE_CHECKING:
    from config.schema.rig import Rig
    from recording.files.session import Session

BETWEEN_ROWS_BYTES = 1 << 20  # events and attachments
COMMAND_RING_BYTES = 8 << 20  # twice the longest planned program
REPORT_BYTES = 1 << 20
_SLOW = "slow."  # before the name of a slow device


class RecorderHealth(NamedTuple):
    """What the recorder reports, as numbers of a mailbox."""

    failed: float  # 1: the file cannot be written
    open: float  # 1: a recording is under way
    file_bytes: float


class SupervisorHealth(NamedTuple):
    """What the supervisor reports to the loop."""

    recorder_lost: float  # 1: the recorder process has ended
    disk_free_bytes: float
    host_rate_Hz: float  # what `longreach host` has seen this computer keep; 0: nothing


class Channels:
    """Named rings and mailboxes. Writer → reader stands beside each."""

    def __init__(self, memory: Mapping[str, SharedMemory]) -> None:
        self._memory = dict(memory)
        self.records = Ring(memory["records"])  # control → recorder
        self.events = Ring(memory["events"])  # control → supervisor
        self.recorder_reports = Ring(memory["recorder_reports"])  # recorder → supervisor
        self.commands = Ring(memory["commands"])  # supervisor → control
        self.set_points = SetPointBox(Mailbox(memory["set_points"]))  # supervisor → control
        self.status = Mailbox(memory["status"])  # control → all
        self.timing = memory["timing"]  # control → supervisor
        self.recorder_health = Mailbox(memory["recorder_health"])  # recorder → control, supervisor
        self.supervisor_health = Mailbox(memory["supervisor_health"])  # supervisor → control
        slow = {name.removeprefix(_SLOW): shared for name, shared in memory.items() if name.startswith(_SLOW)}
        self.slow = {device: Mailbox(shared) for device, shared in slow.items()}  # io → control

    @classmethod
    def create(cls, rig: Rig) -> Channels:
        """New memory for everything, in the sizes that this rig needs."""
        from daemon.checks.interlocks import rig_facts
        from daemon.cycle.log_stream import RECORDER_RING_S
        from daemon.ipc.slow_samples import slow_mailbox
        from recording.format.layout import CycleLayout

        facts = rig_facts(rig)
        rows_bytes = int(RECORDER_RING_S * rig.loop.rate_Hz) * stored_bytes(CycleLayout.of_rig(rig).struct.size)
        memory = {
            "records": Ring.create("records", rows_bytes + BETWEEN_ROWS_BYTES).shared,
            "events": Ring.create("events", REPORT_BYTES).shared,
            "recorder_reports": Ring.create("recorder_reports", REPORT_BYTES).shared,
            "commands": Ring.create("commands", COMMAND_RING_BYTES).shared,
            "set_points": set_point_mailbox(rig).shared,
            "status": Mailbox.create("status", len(facts.names)).shared,
            "timing": SharedMemory.create("timing", 8 * WORDS),
            "recorder_health": Mailbox.create("recorder_health", len(RecorderHealth._fields)).shared,
            "supervisor_health": Mailbox.create("supervisor_health", len(SupervisorHealth._fields)).shared,
        }
        for name, device in rig.devices.items():
            if device.slow:
                memory[f"{_SLOW}{name}"] = slow_mailbox(rig, name).shared
        return cls(memory)

    def loop_is_silent(self) -> bool:
        """The loop has ended, hangs or never began: a process that was asked to end, and serves the loop, may end now."""
        return self.loop_silent_s() > SILENT_S

    def loop_silent_s(self) -> float:
        """Since the loop last said what it is doing; infinite before it has begun."""
        latest = self.status.get()
        return inf if latest is None else (time.monotonic_ns() - latest.stamp_ns) * 1e-9

    def descriptors(self) -> dict[str, int]:
        return {name: memory.descriptor for name, memory in self._memory.items()}


@dataclass(frozen=True, slots=True)
class ChildSpec:
    """What a child process is started with, on its standard input: an argument shows in process lists, and Linux takes 128 KiB.

    The rig comes as the supervisor read it, so that all processes have the same and none reads the file again.
    """

    pickled_rig: bytes
    session: Session
    parent_pid: int
    descriptors: dict[str, int]

    @classmethod
    def of(cls, rig: Rig, session: Session, parent_pid: int, channels: Channels) -> ChildSpec:
        return cls(pickle.dumps(rig), session, parent_pid, channels.descriptors())

    def as_bytes(self) -> bytes:
        return pickle.dumps(self)

    @classmethod
    def from_bytes(cls, content: bytes) -> ChildSpec:
        return cast(ChildSpec, pickle.loads(content))

    def rig(self) -> Rig:
        return cast("Rig", pickle.loads(self.pickled_rig))

    def channels(self) -> Channels:
        return Channels({name: SharedMemory(descriptor) for name, descriptor in self.descriptors.items()})
