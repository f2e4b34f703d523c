"""The daemon's loop on the wall clock, in one process with a twin of its devices: CANopen over a virtual bus, Modbus over TCP."""

from __future__ import annotations

import itertools
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from running_daemon import until

from config.load import LoadedRig, apply_overrides, rig_from_text
from control.signals import Mode
from daemon.clock import WallClock
from daemon.command import Command, CommandQueue
from daemon.device_bank import DeviceBank
from daemon.facts import Facts
from daemon.io_process import SlowDevice
from daemon.lockstep import Alone, DirectSink
from daemon.log_stream import LogStream
from daemon.loop import ControlLoop
from daemon.modes import Event
from daemon.recorder import Recorder, Session
from daemon.slow_samples import slow_mailbox
from daemon.start_request import start_run
from daemon.timing import WORDS, Timing
from recording.event import Event as LogEvent
from recording.event import decode_event
from recording.layout import CycleLayout
from sim_backend.twin.control_socket import TwinControl
from sim_backend.twin.process import Twin

sys.path.insert(0, str(Path(__file__).parents[1] / "sim_backend" / "twin"))
from twin_rig import free_port, twin_rig_text

PATIENT = [  # two loops share one interpreter here
    "loop.rate=250 Hz",
    "loop.spin=0 s",
    "loop.priority=0",
    "loop.overruns.fault_late=1 s",
    "loop.overruns.stop_after=1000",
    "signals.rotary.position.max_age=200 ms",
    "signals.prismatic.position.max_age=200 ms",
    "signals.tip.acceleration.max_age=200 ms",
    "devices.rotary_valve.timeout=0.2 s",
    "devices.io.timeout=0.2 s",
]
_channels = itertools.count()


class CanDaemon:
    """`loop` runs in a thread; `control` injects faults into the twin; `events` are the loop's."""

    def __init__(self, directory: Path, changes: list[str]) -> None:
        channel = f"can daemon {next(_channels)}"
        text = apply_overrides(twin_rig_text(channel, free_port()), [*PATIENT, *changes])
        self.rig = rig_from_text(text)
        self.events: list[LogEvent] = []
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
        self.facts = Facts(rig, layout)
        self.recorder = Recorder(Session(LoadedRig(rig, text, "can.yaml"), directory, {"clock": "wall"}))
        slow = {name: slow_mailbox(rig, name) for name, device in rig.devices.items() if device.slow}
        for name, box in slow.items():
            self._threads.append(threading.Thread(target=SlowDevice(name, rig, box).run, args=(self._ended,), daemon=True))
            self._threads[-1].start()
        bank = DeviceBank(rig, self.facts, lockstep=False, slow=slow)
        bank.open()
        log = LogStream(layout, DirectSink(self.recorder.handle), DirectSink(self._journal))
        return ControlLoop(rig, self.facts, WallClock(0.0), bank, self.commands, log, Alone(self.facts, directory), Timing([0] * WORDS))

    def _journal(self, kind: int, stamp_ns: int, data: bytes) -> None:
        if data:
            self.events.append(decode_event(data))

    @property
    def mode(self) -> Mode:
        return self.loop.keeper.mode

    def value(self, fact: str) -> float:
        return self.loop.values[self.facts.index(fact)]

    def texts(self, name: str) -> list[str]:
        return [event.text for event in self.events if event.name == name]

    def post(self, event: Event) -> None:
        self.commands.post(Command(event))

    def start(self, params: dict[str, Any]) -> None:
        """A run from where the arm is held, with no countdown."""
        self._runs += 1
        held = [self.value(f"{joint}.reference") for joint in self.rig.joints]
        self.commands.post(Command(start=start_run(self.rig, self._runs, {"countdown_s": 0.0, **params}, held)))

    def pressure(self, on: bool) -> None:
        """Of the pump; returns when the daemon has heard of it."""
        self.control.clear("plant")
        if not on:
            self.control.inject("plant", "supply_pressure", 0.0)
        joints = [f"{joint}.supply_pressure_Pa" for joint in self.rig.joints]
        until(lambda: all((self.value(name) > 12e6) if on else (self.value(name) < 0.3e6) for name in joints), 20.0)

    def close(self) -> None:
        self.commands.post(Command(Event.DISARM, leave=True))
        self._threads[-1].join(10)
        self._ended.set()
        self.twin.stop()
        for thread in self._threads:
            thread.join(10)
        self.control.close()


@contextmanager
def can_daemon(directory: Path, changes: list[str] | None = None) -> Iterator[CanDaemon]:
    daemon = CanDaemon(directory, changes or [])
    try:
        yield daemon
    finally:
        daemon.close()
