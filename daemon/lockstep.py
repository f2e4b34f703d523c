"""Runs on the virtual clock: the daemon's loop, recorder and checks in one process, as fast as the computer can, and repeatable.

Two calls with the same arguments write the same cycles, byte for byte.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any

from config.checking.check import refuse_unusable
from config.errors import DaemonError
from config.loading.load import LoadedRig
from config.schema.rig import Rig
from config.whole_file import told_of
from daemon.checks.interlocks import rig_facts
from daemon.cycle.clock import LockstepClock
from daemon.cycle.facts import Facts
from daemon.cycle.log_stream import LogStream
from daemon.cycle.timing import WORDS, Timing
from daemon.host import host_facts
from daemon.loop.command import CommandQueue, LoopCommand, StartRun
from daemon.loop.control_loop import ControlLoop
from daemon.loop.device_bank import CreateDriver, DeviceBank
from daemon.loop.other_processes import OtherProcesses
from daemon.loop.recording_span import Recording
from daemon.loop.set_points import NewestSetPoint
from daemon.modes.mode_machine import OperatorAction
from daemon.modes.run_watch import RunVerdict
from daemon.processes.recorder import Recorder
from daemon.server.start_request import start_run, start_stream
from drivers import registry
from recording.files.session import Session
from recording.format.event import Event, decode_event
from recording.format.layout import CycleLayout
from servo_control.signals import Mode

LONGEST_WAIT_S = 30.0  # simulated time for anything but a run
Progress = Callable[[int, float, float], None]  # request number from 0, elapsed_s, duration_s


def run_lockstep(
    loaded_rig: LoadedRig,
    requests: Sequence[Mapping[str, Any]],
    log_dir: Path,
    seed: int = 0,
    progress: Progress | None = None,
) -> list[Path]:
    """Arm, run, disarm for every request (the params of `start`; no countdown unless asked for). One log a request.

    `seed` of the simulated sensors' noise. Raises DaemonError when a run does not end valid, with its reason; refusals as `start`.
    """
    refuse_unusable(loaded_rig)
    with LockstepRig(loaded_rig, log_dir, seed) as rig:
        return [rig.one_run(request, progress=progress, number=number) for number, request in enumerate(requests)]


def run_into(log: Path, loaded_rig: LoadedRig, request: Mapping[str, Any], seed: int = 0) -> Path:
    """One run, its log under the name `log` and nothing else beside it; the log appears when it is whole. Raises as `run_lockstep`."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with told_of(log), tempfile.TemporaryDirectory(prefix=".longreach-", dir=log.parent) as folder:
        (made,) = run_lockstep(loaded_rig, [request], Path(folder), seed)
        made.replace(log)
    return log


class DirectSink:
    """Hands every record to the recorder at once."""

    dropped = 0

    def __init__(self, handle: Callable[[int, int, bytes], None]) -> None:
        self._handle = handle

    def write(self, kind: int, stamp_ns: int, data: bytes) -> bool:
        self._handle(kind, stamp_ns, data)
        return True


class SingleProcessHealth:
    """Process health of a loop without other processes: all healthy, and the virtual clock keeps any rate."""

    def __init__(self, facts: Facts, log_dir: Path) -> None:
        self._at_disk, self._at_rate = facts.index("disk.free_bytes"), facts.index("host.rate_Hz")
        self._free = float(shutil.disk_usage(log_dir).free)

    def update(self, values: list[float], now_ns: int) -> None:
        values[self._at_disk], values[self._at_rate] = self._free, inf

    def publish(self, values: list[float], now_ns: int, urgent: bool) -> None:
        """There is no reader."""


class LockstepRig:
    """A rig on the virtual clock, for scripts and tests that need more than whole runs. Use it in a with statement."""

    def __init__(self, loaded: LoadedRig, log_dir: Path, seed: int = 0, create: CreateDriver = registry.create) -> None:
        log_dir.mkdir(parents=True, exist_ok=True)
        self.rig = seeded(loaded.rig, seed)
        layout = CycleLayout.of_rig(self.rig)
        self.facts = rig_facts(self.rig)
        facts = {"clock": "lockstep", "seed": str(seed), **host_facts.software(), **host_facts.host()}
        self.recorder = Recorder(Session.of(loaded, log_dir, facts))
        self.events: list[Event] = []
        self.commands, self.set_points = CommandQueue(), NewestSetPoint()
        self.clock = LockstepClock()
        bank = DeviceBank(self.rig, self.facts, lockstep=True, create=create)
        log = LogStream(layout, DirectSink(self.recorder.handle), DirectSink(self._take_event))
        others = OtherProcesses(self.commands, SingleProcessHealth(self.facts, log_dir), self.set_points)
        self.loop = ControlLoop(self.rig, self.facts, self.clock, bank, others, Recording(log, Timing([0] * WORDS)))
        self._runs = 0
        bank.open()

    def _take_event(self, kind: int, stamp_ns: int, data: bytes) -> None:
        if data:
            self.events.append(decode_event(data))

    @property
    def mode(self) -> Mode:
        return self.loop.keeper.mode

    def value(self, fact: str) -> float:
        """A number of the last cycle, by its name in the facts."""
        return self.loop.values[self.facts.index(fact)]

    def post(self, action: OperatorAction) -> None:
        """As an operator would; it acts in the next cycle but one."""
        self.commands.post(LoopCommand(action))

    def cycles(self, count: int) -> None:
        for _ in range(count):
            self.loop.cycle()

    def until(self, condition: Callable[[], bool], longest_s: float = LONGEST_WAIT_S) -> None:
        """Cycle until `condition()`; DaemonError with the last event when it does not come about in simulated time."""
        for _ in range(round(longest_s * self.rig.loop.rate_Hz)):
            if condition():
                return
            self.loop.cycle()
        last = self.events[-1].text if self.events else "nothing happened"
        raise DaemonError("what was waited for did not happen", value=self.mode.name.lower(), limit=longest_s, unit="s", next_step=last)

    def arm(self) -> None:
        """Release the e-stop, arm and hold. DaemonError with the first check that fails."""
        self.cycles(2)
        self.post(OperatorAction.RESET)
        self.post(OperatorAction.ARM)
        self.cycles(4)
        self.until(lambda: self.mode is not Mode.ARMING)
        if self.mode is not Mode.HOLDING:
            failed = [check.sentence(self.loop.values) for check in self.loop.keeper.checks if not check.passes(self.loop.values)]
            raise DaemonError(f"arming was refused: {(failed or [self.loop.keeper.why_fault])[0]}")

    def start(self, params: Mapping[str, Any]) -> int:
        """Ask for a run, with no countdown unless `params` say so; returns its number."""
        return self._start(start_run, params)

    def stream(self, params: Mapping[str, Any] | None = None) -> int:
        """Ask to drive by hand: from now on `set_points` moves the arm. Returns the run's number."""
        return self._start(start_stream, params or {})

    def _start(self, prepare: Callable[..., StartRun], params: Mapping[str, Any]) -> int:
        self._runs += 1
        position = [self.value(f"{joint}.reference") for joint in self.rig.joints]
        self.commands.post(LoopCommand(start=prepare(self.rig, self._runs, {"countdown_s": 0.0, **params}, position)))
        self.cycles(1)
        return self._runs

    def disarm(self) -> None:
        self.post(OperatorAction.DISARM)
        self.cycles(2)

    def one_run(self, params: Mapping[str, Any], progress: Progress | None = None, number: int = 0) -> Path:
        """Arm, run to its end, disarm: one log."""
        self.arm()
        self.start(params)
        run, every = self.loop.keeper.run, round(0.1 * self.rig.loop.rate_Hz)
        while run.active:
            self.cycles(every)
            if progress:
                progress(number, min(run.duration_s, run.elapsed_cycles / self.rig.loop.rate_Hz), run.duration_s)
        self.disarm()
        if run.verdict is not RunVerdict.VALID:  # a fault is still recording
            raise DaemonError("the run is not valid", value=run.reason, where=self.rig.name, next_step="The log ends with what happened.")
        return self.recorder.finished[-1]

    def __enter__(self) -> LockstepRig:
        return self

    def __exit__(self, *error: object) -> None:
        self.loop.end()


def seeded(rig: Rig, seed: int) -> Rig:
    """The rig with the seed in the options of every simulated device."""
    devices = {
        name: device.model_copy(update={"options": {**device.options, "seed": seed}}) if device.driver == "sim" else device
        for name, device in rig.devices.items()
    }
    return rig.model_copy(update={"devices": devices})
