"""The process that runs the control loop and nothing else. Started by the supervisor: python -m daemon.control_process < SPEC."""

from __future__ import annotations

import json
import signal
import sys
import time
from dataclasses import dataclass

from config.errors import LongreachError
from daemon.channels import ChildSpec
from daemon.clock import WallClock
from daemon.command import Command, CommandRing, CommandSource
from daemon.device_bank import DeviceBank
from daemon.facts import Facts
from daemon.log_stream import Kind, LogStream
from daemon.loop import ControlLoop
from daemon.modes import Event
from daemon.neighbours import Neighbours
from daemon.parent_death import signal_on_parent_death
from daemon.realtime import RealtimeFact, request_realtime
from daemon.timing import Timing
from recording.layout import CycleLayout

TOGETHER_S = 0.1


@dataclass(slots=True)
class SignalledCommands:
    """Commands from the ring, and from SIGTERM: the first is a controlled stop, a later one makes the outputs safe at once.

    Linux tells the death of a parent with several threads once for each of them: what comes together with the first is the first.
    """

    ring: CommandSource
    terms: int = 0
    told: int = 0
    first_s: float = 0.0

    def on_signal(self, number: int, frame: object) -> None:
        now_s = time.monotonic()
        if not self.terms:
            self.first_s = now_s
        elif now_s - self.first_s < TOGETHER_S:
            return
        self.terms += 1

    def poll(self) -> Command | None:
        if self.told < self.terms:
            self.told = self.terms
            return Command(Event.DISARM if self.terms > 1 else Event.NONE, leave=True)
        return self.ring.poll()


def main() -> int:
    """Exit status 0 after an orderly end, 1 when a device refused; an exception ends with a traceback after safe outputs."""
    spec = ChildSpec.from_json(sys.stdin.read())
    loaded = spec.loaded_rig()
    rig = loaded.rig
    channels = spec.channels(rig)
    commands = SignalledCommands(CommandRing(channels.commands))
    signal.signal(signal.SIGTERM, commands.on_signal)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C in a terminal is for the supervisor
    signal_on_parent_death(spec.parent_pid)
    layout = CycleLayout.of_rig(rig)
    facts = Facts(rig, layout)
    try:
        bank = DeviceBank(rig, facts, lockstep=False, slow=channels.slow)
        bank.open()
    except LongreachError as error:
        channels.journal.write(Kind.REFUSED, 0, json.dumps({"class": type(error).__name__, **error.refusal.as_dict()}).encode())
        return 1
    granted = request_realtime(rig.loop)
    log = LogStream(layout, channels.records, channels.journal)
    timing = Timing(channels.timing.words)
    clock = WallClock(rig.loop.spin_s)
    loop = ControlLoop(rig, facts, clock, bank, commands, log, Neighbours(channels, facts), timing, _in_log(granted), standby=True)
    channels.journal.write(Kind.HELLO, 0, json.dumps([fact.row() for fact in granted]).encode())
    loop.run()
    return 0


def _in_log(granted: list[RealtimeFact]) -> dict[str, str]:
    return {f"realtime_{fact.name.replace(' ', '_').replace('-', '_')}": fact.value for fact in granted}


if __name__ == "__main__":
    sys.exit(main())
