"""Runs on the virtual clock: the daemon's loop, recorder and checks in one process, as fast as the computer can, and repeatable.

Two calls with the same arguments write the same cycles, byte for byte.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from config.load import LoadedRig
from config.rig import Rig
from control.signals import Mode
from daemon import host_facts
from daemon.clock import LockstepClock
from daemon.command import Command, CommandQueue
from daemon.device_bank import CreateDriver, DeviceBank
from daemon.facts import Facts
from daemon.log_stream import LogStream
from daemon.loop import ControlLoop
from daemon.modes import Event
from daemon.recorder import Recorder, Session
from daemon.run_watch import Verdict
from daemon.start_request import start_run
from daemon.timing import WORDS, Timing
from drivers import registry
from recording.event import Event as LogEvent
from recording.event import decode_event
from recording.layout import CycleLayout

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
    with LockstepRig(loaded_rig, log_dir, seed) as rig:
        return [rig.one_run(request, progress=progress, number=number) for number, request in enumerate(requests)]


class DirectSink:
    """Hands every record to the recorder at once."""

    dropped = 0

    def __init__(self, handle: Callable[[int, int, bytes], None]) -> None:
        self._handle = handle

    def write(self, kind: int, stamp_ns: int, data: bytes) -> bool:
        self._handle(kind, stamp_ns, data)
        return True


class Alone:
    """Surroundings of a loop that has no other processes: all healthy."""

    def __init__(self, facts: Facts, log_dir: Path) -> None:
        self._at_disk = facts.index("disk.free_bytes")
        self._free = float(shutil.disk_usage(log_dir).free)

    def update(self, values: list[float], now_ns: int) -> None:
        values[self._at_disk] = self._free

    def publish(self, values: list[float], now_ns: int, urgent: bool) -> None:
        """Nobody looks."""


class LockstepRig:
    """A rig on the virtual clock, for scripts and tests that want more than whole runs. Use it in a with statement."""

    def __init__(self, loaded: LoadedRig, log_dir: Path, seed: int = 0, create: CreateDriver = registry.create) -> None:
        log_dir.mkdir(parents=True, exist_ok=True)
        self.rig = seeded(loaded.rig, seed)
        layout = CycleLayout.of_rig(self.rig)
        self.facts = Facts(self.rig, layout)
        facts = {"clock": "lockstep", "seed": str(seed), **host_facts.software(), **host_facts.host()}
        self.recorder = Recorder(Session(loaded, log_dir, facts))
        self.events: list[LogEvent] = []
        self.commands = CommandQueue()
        self.clock = LockstepClock()
        bank = DeviceBank(self.rig, self.facts, lockstep=True, create=create)
        log = LogStream(layout, DirectSink(self.recorder.handle), DirectSink(self._journal))
        self.loop = ControlLoop(self.rig, self.facts, self.clock, bank, self.commands, log, Alone(self.facts, log_dir), Timing([0] * WORDS))
        self._runs = 0
        bank.open()

    def _journal(self, kind: int, stamp_ns: int, data: bytes) -> None:
        if data:
            self.events.append(decode_event(data))

    @property
    def mode(self) -> Mode:
        return self.loop.keeper.mode

    def value(self, fact: str) -> float:
        """A number of the last cycle, by its name in the facts."""
        return self.loop.values[self.facts.index(fact)]

    def post(self, event: Event) -> None:
        """As an operator would; it acts in the next cycle but one."""
        self.commands.post(Command(event))

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
        self.post(Event.RESET)
        self.post(Event.ARM)
        self.cycles(4)
        self.until(lambda: self.mode is not Mode.ARMING)
        if self.mode is not Mode.HOLDING:
            failed = [check.sentence(self.loop.values) for check in self.loop.keeper.checks if not check.passes(self.loop.values)]
            raise DaemonError("arming was refused", value=self.mode.name.lower(), next_step=(failed or [self.loop.keeper.why_fault])[0])

    def start(self, params: Mapping[str, Any]) -> int:
        """Ask for a run, with no countdown unless `params` say so; returns its number."""
        self._runs += 1
        position = [self.value(f"{joint}.reference") for joint in self.rig.joints]
        start = start_run(self.rig, self._runs, {"countdown_s": 0.0, **params}, position)
        self.commands.post(Command(start=start))
        self.cycles(1)
        return self._runs

    def disarm(self) -> None:
        self.post(Event.DISARM)
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
        if run.verdict is not Verdict.VALID:  # a fault is still recording
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
