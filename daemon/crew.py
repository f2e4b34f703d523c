"""The supervisor's view of its children: starts them, reads what they report, notices when one dies, and ends them in order."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import sys
import time
from pathlib import Path

from config.errors import DaemonError, DriverError
from config.load import LoadedRig
from control.signals import Mode
from daemon import host_facts
from daemon.channels import Channels, ChildSpec, RecorderHealth, SupervisorHealth
from daemon.children import Child
from daemon.command import Command, CommandRing
from daemon.desk import Desk
from daemon.facts import Facts
from daemon.journal import Journal
from daemon.log_stream import Kind
from daemon.modes import Event
from daemon.notify import notify
from daemon.runtime_lock import RuntimeLock
from daemon.status import StatusView
from daemon.timing import Timing
from recording.event import Event as LogEvent
from recording.event import Level, decode_event
from recording.layout import CycleLayout

LOOK_S = 0.02
TELL_SYSTEMD_S = 0.2  # a fifth of the unit's WatchdogSec
DISK_LOOK_S = 1.0
START_LIMIT_S = 120.0  # the first start on a machine compiles the simulation
STOP_LIMIT_S = 8.0  # controlled stop (5 s at most) and two seconds of log after a fault
CLOSE_LIMIT_S = 3.0
RECORDER_START_LIMIT_S = 10.0


class Crew:
    """The child processes of one daemon and all they report. `watch` runs until the daemon ends."""

    def __init__(self, rig: LoadedRig, log_dir: Path, runtime: Path, lock: RuntimeLock) -> None:
        self._loaded, self._log_dir, self._runtime, self._lock = rig, log_dir, runtime, lock
        self._host = {"clock": "wall", **host_facts.software(), **host_facts.host()}
        self._channels = channels = Channels.create(rig.rig)
        self.facts = Facts(rig.rig, CycleLayout.of_rig(rig.rig))
        self.journal = Journal()
        self.view = StatusView(rig.rig, self.facts, Timing(channels.timing.words))
        self._commands = CommandRing(channels.commands)
        self._children: dict[str, Child] = {}
        self._desk: Desk | None = None
        self._values: tuple[float, ...] = tuple(self.facts.blank())
        self._posted = self._shutdowns = self._seen_sequence = 0
        self._disk_free = self._next_disk_look = self._next_tell = 0.0
        self._refusal: DriverError | None = None
        self._greeted = False
        self._lost: set[str] = set()

    def start(self, desk: Desk) -> None:
        """Start every process the rig needs. `desk` is told about the log and the real-time facts."""
        self._desk = desk
        self._look()
        slow = any(device.slow for device in self._loaded.rig.devices.values())
        for name in ("recorder", "control", *(["io"] if slow else [])):
            self._spawn(name)

    def _spawn(self, name: str) -> None:
        loaded, descriptors = self._loaded, self._channels.descriptors()
        spec = ChildSpec(loaded.text, loaded.path, str(self._log_dir), os.getpid(), descriptors, self._host)
        self._children[name] = Child(name, spec, {"RUNTIME_DIRECTORY": str(self._runtime)}, (self._lock.descriptor,))

    async def until_ready(self) -> None:
        """Disarmed, every device has answered, the recorder reports. Raises the refusal of a device, or DaemonError."""
        limit = time.monotonic() + START_LIMIT_S
        while not (self._greeted and self._channels.status.sequence and self._channels.recorder_health.sequence):
            self._look()
            if self._refusal is not None:
                raise self._refusal
            if self._shutdowns:
                return
            for child in self._children.values():
                if child.ended():
                    raise DaemonError(f"the {child.name} process ended while starting", value=child.how_it_ended())
            if time.monotonic() > limit:
                raise DaemonError("the processes did not start", limit=START_LIMIT_S, unit="s", next_step="See the messages above.")
            await asyncio.sleep(LOOK_S)

    async def watch(self) -> int:
        """Look after everything until the control process has ended; the daemon's exit status."""
        control = self._children["control"]
        ends_by = 0.0
        while not control.ended():
            self._look()
            self._tell_systemd()
            if self._shutdowns and not ends_by:
                ends_by = time.monotonic() + STOP_LIMIT_S
            if ends_by and time.monotonic() > ends_by:
                self._tell("supervisor", f"the loop did not end within {STOP_LIMIT_S:g} s; it is killed, the devices time out", Level.ERROR)
                control.kill()
            await asyncio.sleep(LOOK_S)
        orderly = bool(self._shutdowns) and control.how_it_ended() == "exit status 0"
        if not orderly:
            self._tell(
                "control_died", f"the control process ended ({control.how_it_ended()}); its devices time out to safe outputs", Level.FAULT
            )
        await self._end_others()
        return 0 if orderly else 1

    async def _end_others(self) -> None:
        """The recorder writes what is left and closes its file."""
        notify("STOPPING=1")
        limit = time.monotonic() + CLOSE_LIMIT_S
        others = [child for name, child in self._children.items() if name != "control"]
        for child in others:
            child.terminate()
        while not all(child.ended() for child in others) and time.monotonic() < limit:
            self._look()
            await asyncio.sleep(LOOK_S)

    def kill(self) -> None:
        """End what is still there."""
        for child in self._children.values():
            if not child.ended():
                child.kill()

    def values(self) -> tuple[float, ...]:
        """The latest facts of the loop; the journal then knows at least what led to them."""
        letter = self._channels.status.get()
        if letter is not None:
            self._values = letter.values
        self._read_journals()
        return self._values

    def post(self, command: Command) -> int:
        """Hand the loop a command: its number since the start, 0 when the loop does not take it."""
        if not self._commands.post(command):
            return 0
        self._posted += 1
        return self._posted

    def shut_down(self) -> None:
        """The first call is a controlled stop, the second makes the outputs safe at once."""
        self._shutdowns += 1
        notify("STOPPING=1")
        self.post(Command(Event.DISARM if self._shutdowns > 1 else Event.NONE, leave=True))

    async def repair_recorder(self) -> None:
        """Part of a reset: a recorder that has ended, or cannot write, is started anew, and that is told."""
        recorder, health = self._children["recorder"], self._channels.recorder_health.get()
        if not recorder.ended() and not (health and RecorderHealth(*health.values).failed):
            return
        recorder.kill()
        before = self._channels.recorder_health.sequence
        self._spawn("recorder")
        self._lost.discard("recorder")
        self._tell("recorder_started", "the recorder was started again by a reset", Level.WARNING)
        limit, failed = time.monotonic() + RECORDER_START_LIMIT_S, self.facts.index("recorder.failed")
        while self._channels.recorder_health.sequence == before or self.values()[failed]:
            if time.monotonic() > limit:
                raise DaemonError("the recorder does not start", limit=RECORDER_START_LIMIT_S, unit="s", next_step="Restart the daemon.")
            await asyncio.sleep(LOOK_S)

    def _look(self) -> None:
        """One look at everything the children report."""
        self._read_journals()
        for name, child in self._children.items():
            if name != "control" and child.ended() and name not in self._lost and not self._shutdowns:
                self._lost.add(name)
                self._tell(f"{name}_died", f"the {name} process ended ({child.how_it_ended()})", Level.ERROR)
        now = time.monotonic()
        if now >= self._next_disk_look:
            self._next_disk_look = now + DISK_LOOK_S
            self._disk_free = float(shutil.disk_usage(self._log_dir).free)
        health = SupervisorHealth(float("recorder" in self._lost), self._disk_free)
        self._channels.supervisor_health.put(time.monotonic_ns(), health)

    def _read_journals(self) -> None:
        while (record := self._channels.journal.read()) is not None:
            if record.kind == Kind.EVENT:
                self._add(decode_event(record.data))
            elif record.kind == Kind.HELLO and self._desk is not None:
                self._greeted = True
                self._desk.host_rows = json.loads(record.data)
            elif record.kind == Kind.REFUSED:
                parts = json.loads(record.data)
                self._refusal = DriverError(parts.pop("what"), **{key: parts[key] for key in parts if key != "class"})
        while (record := self._channels.recorder_journal.read()) is not None:
            self._hear_recorder(json.loads(record.data))
        letter = self._channels.recorder_health.get()
        if letter is not None and self._desk is not None:
            self._desk.log["bytes"] = int(RecorderHealth(*letter.values).file_bytes)

    def _hear_recorder(self, content: dict[str, str]) -> None:
        if "path" in content and self._desk is not None:
            self._desk.log["path"] = content["path"]
        if "error" in content:
            self._tell("recorder", content["error"], Level.ERROR)

    def _tell(self, name: str, text: str, level: Level) -> None:
        """An event of the supervisor itself."""
        at = self.facts.index
        self._add(LogEvent(int(self._values[at("cycle")]), self._values[at("t_s")], level, name, text))

    def _add(self, event: LogEvent) -> None:
        entry = self.journal.add(event)
        print(f"longreachd: {entry['t_s']:.3f} s {entry['level']} {entry['name']}: {entry['text']}", file=sys.stderr, flush=True)

    def _tell_systemd(self) -> None:
        """The watchdog is fed only while the loop moves on."""
        now, sequence = time.monotonic(), self._channels.status.sequence
        if now < self._next_tell:
            return
        self._next_tell = now + TELL_SYSTEMD_S
        if sequence == self._seen_sequence:
            return
        self._seen_sequence = sequence
        values = self.values()
        mode = self.view.mode(values)
        why = f": {self.journal.fault['text']}" if mode is Mode.FAULT and self.journal.fault else ""
        notify("WATCHDOG=1", f"STATUS={mode.name.lower()}, cycle {int(values[self.facts.index('cycle')])}{why}")
