"""The daemon's loop on the wall clock, in one process with a twin of its devices: CANopen over a virtual bus, Modbus over TCP."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from config.loading.load import LoadedRig, apply_overrides, rig_from_text
from config.options.canopen_rig import canopen_devices
from config.schema.rig import Rig
from daemon.checks.interlocks import rig_facts
from daemon.cycle.clock import WallClock
from daemon.cycle.log_stream import LogStream
from daemon.cycle.timing import WORDS, Timing
from daemon.ipc.slow_samples import slow_mailbox
from daemon.lockstep import DirectSink, SingleProcessHealth
from daemon.loop.command import CommandQueue, LoopCommand
from daemon.loop.control_loop import ControlLoop
from daemon.loop.device_bank import DeviceBank
from daemon.loop.other_processes import OtherProcesses
from daemon.loop.recording_span import Recording
from daemon.modes.mode_machine import OperatorAction
from daemon.processes.io_process import SlowDevice
from daemon.processes.recorder import Recorder
from daemon.server.start_request import start_run
from recording.files.session import Session
from recording.format.event import Event, decode_event
from recording.format.layout import CycleLayout
from servo_control.signals import Mode
from sim_backend.twin.control_socket import TwinControl
from sim_backend.twin.process import Twin
from tests.support.daemon.running_daemon import until
from tests.support.sim_backend.twin_rig import free_port, twin_rig_text

RigText = Callable[[str, int], str]
PATIENT = [  # two loops share one interpreter here
    "loop.rate=250 Hz",
    "loop.spin=0 s",
    "loop.priority=0",
    "loop.overruns.fault_late=1 s",
    "loop.overruns.stop_after=1000",
]
PATIENCE_S = 0.2
_channels = itertools.count()


class CanDaemon:
    """`loop` runs in a thread; `control` injects faults into the twin; `events` are the loop's."""

    def __init__(self, directory: Path, changes: list[str], rig_text: RigText) -> None:
        channel = f"can daemon {next(_channels)}"
        plain = rig_text(channel, free_port())
        text = apply_overrides(plain, [*PATIENT, *patient_devices(rig_from_text(plain)), *changes])
        self.rig = rig_from_text(text)
        self.events: list[Event] = []
        self._runs = 0
        self.commands = CommandQueue()
        self.twin = Twin(self.rig, "virtual", channel, directory / "twin.sock")
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=self.twin.run, daemon=True)]
        self._threads[0].start()
        self.control = TwinControl(directory / "twin.sock", timeout_s=20)
        until(lambda: self.twin.bench.clock.caught_up > 0, 30.0)
        self.loop = self._make_loop(directory, text)
        self._threads.append(threading.Thread(target=self.loop.run, daemon=True))
        self._threads[-1].start()

    def _make_loop(self, directory: Path, text: str) -> ControlLoop:
        rig, layout = self.rig, CycleLayout.of_rig(self.rig)
        self.facts = rig_facts(rig)
        self.recorder = Recorder(Session.of(LoadedRig(rig, text, "can.yaml"), directory, {"clock": "wall"}))
        slow = {name: slow_mailbox(rig, name) for name, device in rig.devices.items() if device.slow}
        for name, box in slow.items():
            self._threads.append(threading.Thread(target=SlowDevice(name, rig, box).run, args=(self._ended,), daemon=True))
            self._threads[-1].start()
        bank = DeviceBank(rig, self.facts, lockstep=False, slow=slow)
        bank.open()
        log = LogStream(layout, DirectSink(self.recorder.handle), DirectSink(self._take_event))
        others = OtherProcesses(self.commands, SingleProcessHealth(self.facts, directory))
        return ControlLoop(rig, self.facts, WallClock(0.0, 1.0 / rig.loop.rate_Hz), bank, others, Recording(log, Timing([0] * WORDS)))

    def _take_event(self, kind: int, stamp_ns: int, data: bytes) -> None:
        if data:
            self.events.append(decode_event(data))

    @property
    def mode(self) -> Mode:
        return self.loop.keeper.mode

    def value(self, fact: str) -> float:
        return self.loop.values[self.facts.index(fact)]

    def texts(self, name: str) -> list[str]:
        return [event.text for event in self.events if event.name == name]

    def post(self, action: OperatorAction) -> None:
        self.commands.post(LoopCommand(action))

    def start(self, params: dict[str, Any]) -> None:
        """A run from where the arm is held, with no countdown."""
        self._runs += 1
        held = [self.value(f"{joint}.reference") for joint in self.rig.joints]
        self.commands.post(LoopCommand(start=start_run(self.rig, self._runs, {"countdown_s": 0.0, **params}, held)))

    def pressure(self, on: bool) -> None:
        """Of the pump; returns when the daemon has heard of it."""
        self.control.clear("plant")
        if not on:
            self.control.inject("plant", "supply_pressure", 0.0)
        joints = [f"{joint}.supply_pressure_Pa" for joint in self.rig.joints]
        until(lambda: all((self.value(name) > 12e6) if on else (self.value(name) < 0.3e6) for name in joints), 20.0)

    def close(self) -> None:
        self.commands.post(LoopCommand(OperatorAction.DISARM, leave=True))
        self._threads[-1].join(10)
        self._ended.set()
        self.twin.stop()
        for thread in self._threads:
            thread.join(10)
        self.control.close()


def patient_devices(rig: Rig) -> list[str]:
    """The same of ages and of what supervises us."""
    ages = [f"signals.{name}.max_age={PATIENCE_S} s" for name, signal in rig.signals.items() if signal.max_age_s < PATIENCE_S]
    supervised = [name for name, options in canopen_devices(rig).items() if options.must_prove()]
    return [*ages, *(f"devices.{name}.timeout={PATIENCE_S} s" for name in supervised)]


@contextmanager
def can_daemon(directory: Path, changes: list[str] | None = None, rig_text: RigText = twin_rig_text) -> Iterator[CanDaemon]:
    """`rig_text`: of a CAN channel and a Modbus port."""
    daemon = CanDaemon(directory, changes or [], rig_text)
    try:
        yield daemon
    finally:
        daemon.close()
