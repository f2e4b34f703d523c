"""Every piece of memory the daemon's processes share, made by the supervisor and handed to each child by descriptor."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

from config.load import LoadedRig, rig_from_text
from config.rig import Rig
from daemon.facts import Facts
from daemon.mailbox import Mailbox
from daemon.ring import Ring
from daemon.shared_memory import SharedMemory
from daemon.slow_samples import slow_mailbox
from daemon.timing import WORDS
from recording.layout import CycleLayout

RECORDER_RING_BYTES = 8 << 20  # about 8 s of rows at 1 kHz
COMMAND_RING_BYTES = 4 << 20  # a long planned program
JOURNAL_BYTES = 1 << 20
LOOP_SILENT_S = 0.5  # without a cycle


class RecorderHealth(NamedTuple):
    """What the recorder reports, as numbers of a mailbox."""

    failed: float  # 1: the file cannot be written
    open: float  # 1: a recording is under way
    file_bytes: float


class SupervisorHealth(NamedTuple):
    """What the supervisor reports to the loop."""

    recorder_lost: float  # 1: the recorder process has ended
    disk_free_bytes: float


class Channels:
    """Named rings and mailboxes. Writer → reader stands beside each."""

    def __init__(self, rig: Rig, memory: Mapping[str, SharedMemory]) -> None:
        self._memory = dict(memory)
        self.records = Ring(memory["records"])  # control → recorder
        self.journal = Ring(memory["journal"])  # control → supervisor
        self.recorder_journal = Ring(memory["recorder_journal"])  # recorder → supervisor
        self.commands = Ring(memory["commands"])  # supervisor → control
        self.status = Mailbox(memory["status"])  # control → all
        self.timing = memory["timing"]  # control → supervisor
        self.recorder_health = Mailbox(memory["recorder_health"])  # recorder → control, supervisor
        self.supervisor_health = Mailbox(memory["supervisor_health"])  # supervisor → control
        self.slow = {name: Mailbox(memory[f"slow.{name}"]) for name, device in rig.devices.items() if device.slow}  # io → control

    @classmethod
    def create(cls, rig: Rig) -> Channels:
        facts = Facts(rig, CycleLayout.of_rig(rig))
        memory = {
            "records": Ring.create("records", RECORDER_RING_BYTES).shared,
            "journal": Ring.create("journal", JOURNAL_BYTES).shared,
            "recorder_journal": Ring.create("recorder_journal", JOURNAL_BYTES).shared,
            "commands": Ring.create("commands", COMMAND_RING_BYTES).shared,
            "status": Mailbox.create("status", len(facts.names)).shared,
            "timing": SharedMemory.create("timing", 8 * WORDS),
            "recorder_health": Mailbox.create("recorder_health", len(RecorderHealth._fields)).shared,
            "supervisor_health": Mailbox.create("supervisor_health", len(SupervisorHealth._fields)).shared,
        }
        for name, device in rig.devices.items():
            if device.slow:
                memory[f"slow.{name}"] = slow_mailbox(rig, name).shared
        return cls(rig, memory)

    def loop_is_silent(self) -> bool:
        """The loop has ended, hangs or never began: who was asked to end, and serves it, may."""
        letter = self.status.get()
        return letter is None or time.monotonic_ns() - letter.stamp_ns > LOOP_SILENT_S * 1e9

    def descriptors(self) -> dict[str, int]:
        return {name: memory.descriptor for name, memory in self._memory.items()}


@dataclass(frozen=True, slots=True)
class ChildSpec:
    """All a child process is told, as JSON on its standard input: as an argument a rig would fill process lists, and Linux takes 128 KiB.

    The rig comes as text, so that all processes have the same.
    """

    rig_text: str
    rig_path: str
    log_dir: str
    parent_pid: int
    descriptors: dict[str, int]
    facts: dict[str, str]

    def as_json(self) -> str:
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> ChildSpec:
        return cls(**json.loads(text))

    def loaded_rig(self) -> LoadedRig:
        return LoadedRig(rig_from_text(self.rig_text, self.rig_path), self.rig_text, self.rig_path)

    def channels(self, rig: Rig) -> Channels:
        return Channels(rig, {name: SharedMemory(descriptor) for name, descriptor in self.descriptors.items()})

    @property
    def log_path(self) -> Path:
        return Path(self.log_dir)
