"""The child processes as the supervisor sees them: it starts them, reads their reports, notices when one dies, and ends them in turn."""

from __future__ import annotations

import asyncio
import json
import os
import sys
import time
from contextlib import suppress
from math import inf, isfinite
from pathlib import Path

from config.errors import DaemonError, DriverError
from config.loading.load import LoadedRig
from config.loading.stated_units import sentence_units
from config.stated_sentences import StatedSentences
from daemon.checks.interlocks import rig_facts
from daemon.cycle.log_stream import RecordKind
from daemon.cycle.timing import Timing
from daemon.host import host_facts
from daemon.loop.command import CommandRing, LoopCommand
from daemon.modes.mode_machine import OperatorAction
from daemon.processes.channels import Channels, ChildSpec, RecorderHealth, SupervisorHealth
from daemon.processes.children import Child
from daemon.processes.computer import ComputerWatch
from daemon.processes.runtime_lock import RuntimeLock
from daemon.processes.sd_notify import notify
from daemon.server.event_history import EventHistory
from daemon.server.loop_silence import SILENT_S, SilenceTeller
from daemon.server.request_handlers import RequestHandlers
from daemon.server.status import StatusView
from recording.files.session import Session
from recording.format.event import Event, Level, decode_event
from servo_control.signals import Mode, SetPoint

POLL_S = 0.02
WATCHDOG_S = 0.2  # a fifth of the unit's WatchdogSec
START_LIMIT_S = 120.0  # the first start on a machine compiles the simulation
STOP_LIMIT_S = 8.0  # controlled stop (5 s at most) and two seconds of log after a fault
CLOSE_LIMIT_S = 3.0
RECORDER_START_LIMIT_S = 10.0


class ChildSupervision:
    """The child processes of one daemon, what they report, and the way to the loop. `watch` runs until the daemon ends."""

    def __init__(self, rig: LoadedRig, log_dir: Path, runtime: Path, lock: RuntimeLock) -> None:
        self._loaded, self._log_dir, self._runtime, self._lock = rig, log_dir, runtime, lock
        self._computer = ComputerWatch(rig.rig, log_dir)
        self._host = {"clock": "wall", **host_facts.software(), **host_facts.host(), "host_grade": self._computer.grade}
        self._channels = channels = Channels.create(rig.rig)
        self.facts = rig_facts(rig.rig)
        self.history = EventHistory()
        self._sentences = StatedSentences(sentence_units(rig.text))
        self.view = StatusView(rig.rig, self.facts, Timing(channels.timing.words))
        self._commands = CommandRing(channels.commands)
        self._children: dict[str, Child] = {}
        self._handlers: RequestHandlers | None = None
        self._values: tuple[float, ...] = tuple(self.facts.blank())
        self._posted = self._shutdowns = self._watchdog_sequence = 0
        self._silence, self._sequence_when_ready = SilenceTeller(self._add_event), 0
        self._next_watchdog = 0.0
        self._refusal: DriverError | None = None
        self._control_ready = False
        self._lost: set[str] = set()

    def start(self, handlers: RequestHandlers) -> None:
        """Start every process the rig needs. `handlers` get the path and size of the log and the real-time facts."""
        self._handlers, handlers.host_rows = handlers, self._computer.rows
        self._add_event("host", f"host grade: {self._computer.grade}", Level.INFO)
        self._poll()
        slow = any(device.slow for device in self._loaded.rig.devices.values())
        for name in ("recorder", "control", *(["io"] if slow else [])):
            self._spawn(name)

    def _spawn(self, name: str) -> None:
        session = Session.of(self._loaded, self._log_dir, self._host)
        spec = ChildSpec.of(self._loaded.rig, session, os.getpid(), self._channels)
        self._children[name] = Child(name, spec, {"RUNTIME_DIRECTORY": str(self._runtime)}, (self._lock.descriptor,))

    async def until_ready(self) -> None:
        """Disarmed, every device has answered, the recorder reports; or the daemon was told to end (`leaving`). Raises the refusal of a
        device, or DaemonError."""
        limit = time.monotonic() + START_LIMIT_S
        while not (self._control_ready and self._channels.status.sequence and self._channels.recorder_health.sequence):
            self._poll()
            if self._refusal is not None:
                raise self._refusal
            if self.leaving:
                return
            for child in self._children.values():
                if child.ended():
                    raise DaemonError(f"the {child.name} process ended while starting", value=child.how_it_ended())
            if time.monotonic() > limit:
                raise DaemonError("the processes did not start", limit=START_LIMIT_S, unit="s", next_step="See the messages above.")
            await asyncio.sleep(POLL_S)

    @property
    def leaving(self) -> bool:
        """Told to end."""
        return self._shutdowns > 0

    async def watch(self) -> int:
        """Poll until the control process has ended; returns the daemon's exit status."""
        control = self._children["control"]
        ends_by = 0.0
        while not control.ended():
            self._poll()
            self._feed_watchdog()
            if self.leaving and not ends_by:
                ends_by = time.monotonic() + (STOP_LIMIT_S if self._control_ready else START_LIMIT_S)
            if ends_by and time.monotonic() > ends_by:
                self._add_event("supervisor", "the loop did not end in time; it is killed, the devices time out", Level.ERROR)
                control.kill()
                ends_by = inf
            await asyncio.sleep(POLL_S)
        orderly = bool(self._shutdowns) and control.how_it_ended() == "exit status 0"
        if not orderly:
            self._add_event(
                "control_died", f"the control process ended ({control.how_it_ended()}); its devices time out to safe outputs", Level.FAULT
            )
        await self._end_others()
        return 0 if orderly else 1

    async def _end_others(self) -> None:
        """The recorder writes what is left in the ring and closes its file."""
        notify("STOPPING=1")
        limit = time.monotonic() + CLOSE_LIMIT_S
        others = [child for name, child in self._children.items() if name != "control"]
        for child in others:
            child.terminate()
        while not all(child.ended() for child in others) and time.monotonic() < limit:
            self._poll()
            await asyncio.sleep(POLL_S)
        self._kill()

    async def end(self) -> None:
        """Whatever is still there, also when the supervisor fails: a controlled stop and a closed log; killed is what does not end."""
        limit = time.monotonic() + STOP_LIMIT_S
        alive = [child for child in self._children.values() if not child.ended()]
        for child in alive:
            child.terminate()
        while not all(child.ended() for child in alive) and time.monotonic() < limit:
            with suppress(Exception):  # what the supervisor fails with must not keep the arm from stopping
                self._feed_watchdog()
            await asyncio.sleep(POLL_S)
        self._kill()

    def _kill(self) -> None:
        for child in self._children.values():
            if not child.ended():
                child.kill()

    def values(self) -> tuple[float, ...]:
        """The latest facts of the loop. The history then holds every event up to them, at least."""
        latest = self._channels.status.get()
        if latest is not None:
            self._values = latest.values
        self._read_reports()
        return self._values

    def silent_s(self) -> float:
        """For how long the loop has stood still; 0 while it moves on, has not begun, or has ended."""
        has_begun = self._control_ready and self._channels.status.sequence != self._sequence_when_ready
        silent_s = self._channels.loop_silent_s() if has_begun and not self._children["control"].ended() else 0.0
        return silent_s if silent_s > SILENT_S else 0.0

    def post(self, command: LoopCommand) -> int:
        """Hand the loop a command: its number since the start, 0 when the loop does not take it."""
        if not self._commands.post(command):
            return 0
        self._posted += 1
        return self._posted

    def post_set_point(self, point: SetPoint) -> None:
        self._channels.set_points.post(point)

    def shut_down(self) -> None:
        """The first call is a controlled stop, the second makes the outputs safe at once."""
        self._shutdowns += 1
        notify("STOPPING=1")
        self.post(LoopCommand(OperatorAction.DISARM if self._shutdowns > 1 else OperatorAction.NONE, leave=True))

    async def repair(self) -> bool:
        """Part of a reset: start anew what has ended beside the loop, with an event that says so. Whether the recorder was."""
        if "io" in self._lost:
            self._spawn("io")
            self._lost.discard("io")
            self._add_event("io_started", "the process that asks the slow devices was started again by a reset", Level.WARNING)
        return await self._repair_recorder()

    async def _repair_recorder(self) -> bool:
        """Also when it cannot write."""
        recorder, health = self._children["recorder"], self._channels.recorder_health.get()
        if not recorder.ended() and not (health and RecorderHealth(*health.values).failed):
            return False
        recorder.kill()
        before = self._channels.recorder_health.sequence
        self._spawn("recorder")
        self._lost.discard("recorder")
        self._add_event("recorder_started", "the recorder was started again by a reset", Level.WARNING)
        limit, failed = time.monotonic() + RECORDER_START_LIMIT_S, self.facts.index("recorder.failed")
        while self._channels.recorder_health.sequence == before or self.values()[failed]:
            if time.monotonic() > limit:
                raise DaemonError("the recorder does not start", limit=RECORDER_START_LIMIT_S, unit="s", next_step="Restart the daemon.")
            await asyncio.sleep(POLL_S)
        return True

    def _poll(self) -> None:
        """Read every report once, notice ended processes, and report our own health to the loop."""
        self._read_reports()
        for name, child in self._children.items():
            if name != "control" and child.ended() and name not in self._lost and not self._shutdowns:
                self._lost.add(name)
                self._add_event(f"{name}_died", f"the {name} process ended ({child.how_it_ended()}); a reset starts it again", Level.ERROR)
        self._silence.tell(self.silent_s())
        self._computer.look()
        health = SupervisorHealth(float("recorder" in self._lost), self._computer.disk_free_bytes, self._computer.rate_Hz)
        self._channels.supervisor_health.put(time.monotonic_ns(), health)

    def _read_reports(self) -> None:
        while (record := self._channels.events.read()) is not None:
            if record.kind == RecordKind.EVENT:
                self._add(decode_event(record.data))
            elif record.kind == RecordKind.READY and self._handlers is not None:
                self._control_ready, self._sequence_when_ready = True, self._channels.status.sequence
                self._computer.granted = json.loads(record.data)
            elif record.kind == RecordKind.REFUSED:
                parts = json.loads(record.data)
                self._refusal = DriverError(parts.pop("what"), **{key: parts[key] for key in parts if key != "class"})
        while (record := self._channels.recorder_reports.read()) is not None:
            self._read_recorder_report(json.loads(record.data))
        latest = self._channels.recorder_health.get()
        if latest is not None and self._handlers is not None:
            self._handlers.log["bytes"] = int(RecorderHealth(*latest.values).file_bytes)

    def _read_recorder_report(self, content: dict[str, str]) -> None:
        if "path" in content and self._handlers is not None:
            self._handlers.log["path"] = content["path"]
        if "error" in content:
            self._add_event("recorder", content["error"], Level.ERROR)

    def _add_event(self, name: str, text: str, level: Level) -> None:
        """An event of the supervisor itself."""
        at = self.facts.index
        t_s = self._values[at("t_s")]
        self._add(Event(int(self._values[at("cycle")]), t_s if isfinite(t_s) else 0.0, level, name, text))

    def _add(self, event: Event) -> None:
        entry = self.history.add(event)
        text = self._sentences.text(str(entry["text"]))
        with suppress(OSError):  # nobody reads it any more; the socket and the log have it
            print(f"longreachd: {entry['t_s']:.3f} s {entry['level']} {entry['name']}: {text}", file=sys.stderr, flush=True)

    def _feed_watchdog(self) -> None:
        """The watchdog is fed only while the loop moves on."""
        now, sequence = time.monotonic(), self._channels.status.sequence
        if now < self._next_watchdog:
            return
        self._next_watchdog = now + WATCHDOG_S
        if sequence == self._watchdog_sequence:
            return
        self._watchdog_sequence = sequence
        values = self.values()
        mode = self.view.mode(values)
        why = f": {self._sentences.text(str(self.history.fault['text']))}" if mode is Mode.FAULT and self.history.fault else ""
        notify("WATCHDOG=1", f"STATUS={mode.name.lower()}, cycle {int(values[self.facts.index('cycle')])}{why}")
