"""The process that runs the control loop and nothing else. Started by the supervisor: python -m daemon.processes.control_process < SPEC."""

from __future__ import annotations

import json
import signal
import sys
import time
from dataclasses import dataclass

from config.errors import LongreachError
from config.schema.rig import Rig
from daemon.checks.interlocks import rig_facts
from daemon.cycle.clock import WallClock
from daemon.cycle.log_stream import LogStream, RecordKind
from daemon.cycle.timing import Timing
from daemon.host.realtime import RealtimeFact, request_realtime
from daemon.loop.command import CommandRing, CommandSource, LoopCommand
from daemon.loop.control_loop import ControlLoop
from daemon.loop.device_bank import DeviceBank
from daemon.loop.other_processes import OtherProcesses
from daemon.loop.recording_span import Recording
from daemon.modes.mode_machine import OperatorAction
from daemon.processes.channels import Channels, ChildSpec
from daemon.processes.children import leave_terminal_to_supervisor, signal_on_parent_death
from daemon.processes.process_health import MailboxHealth
from recording.format.layout import CycleLayout

REPEATED_SIGNAL_S = 0.1


@dataclass(slots=True)
class SignalledCommands:
    """Commands from the ring, and from SIGTERM: the first is a controlled stop, a later one makes the outputs safe at once.

    Linux signals the death of a parent once for each of its threads: a signal within REPEATED_SIGNAL_S of the first is the same one.
    """

    ring: CommandSource
    terms: int = 0
    delivered: int = 0
    first_s: float = 0.0

    def on_signal(self, number: int, frame: object) -> None:
        now_s = time.monotonic()
        if not self.terms:
            self.first_s = now_s
        elif now_s - self.first_s < REPEATED_SIGNAL_S:
            return
        self.terms += 1

    def poll(self) -> LoopCommand | None:
        if self.delivered < self.terms:
            self.delivered = self.terms
            return LoopCommand(OperatorAction.DISARM if self.terms > 1 else OperatorAction.NONE, leave=True)
        return self.ring.poll()


def main() -> int:
    """Exit status 0 after an orderly end, 1 when a device refused; an exception ends with a traceback after safe outputs."""
    spec = ChildSpec.from_bytes(sys.stdin.buffer.read())
    rig, channels = spec.rig(), spec.channels()
    commands = SignalledCommands(CommandRing(channels.commands))
    signal.signal(signal.SIGTERM, commands.on_signal)
    leave_terminal_to_supervisor()
    signal_on_parent_death(spec.parent_pid)
    try:
        loop, granted = _opened_loop(rig, channels, commands)
    except LongreachError as error:
        channels.events.write(RecordKind.REFUSED, 0, json.dumps({"class": type(error).__name__, **error.refusal.as_dict()}).encode())
        return 1
    channels.events.write(RecordKind.READY, 0, json.dumps([fact.row() for fact in granted]).encode())
    loop.run()
    return 0


def _opened_loop(rig: Rig, channels: Channels, commands: CommandSource) -> tuple[ControlLoop, list[RealtimeFact]]:
    """The loop with its devices open, and what the operating system granted it. LongreachError when a device refuses."""
    facts = rig_facts(rig)
    bank = DeviceBank(rig, facts, lockstep=False, slow=channels.slow)
    bank.open()
    granted = request_realtime(rig.loop)
    log = LogStream(CycleLayout.of_rig(rig), channels.records, channels.events)
    recording = Recording(log, Timing(channels.timing.words), _in_log(granted), standby=True)
    others = OtherProcesses(commands, MailboxHealth(channels, facts, rig.loop.rate_Hz), channels.set_points)
    return ControlLoop(rig, facts, WallClock(rig.loop.spin_s, 1.0 / rig.loop.rate_Hz), bank, others, recording), granted


def _in_log(granted: list[RealtimeFact]) -> dict[str, str]:
    return {f"realtime_{fact.name.replace(' ', '_').replace('-', '_')}": fact.value for fact in granted}


if __name__ == "__main__":
    sys.exit(main())
