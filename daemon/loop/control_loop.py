"""The control loop: wait → read → checks and mode → controller → write → record, at a fixed rate, on either clock.

Clock, devices, commands, health and log are given from outside, so lockstep and wall clock run the same code. Every way out of
`run` makes the outputs safe. In a cycle: plain floats, no lock, no wait but the clock's, nothing that grows.
"""

from __future__ import annotations

from dataclasses import dataclass

from config.schema.rig import Rig
from daemon.checks.interlocks import watches
from daemon.checks.link_watch import LinkWatch
from daemon.checks.safe_state import SafeState
from daemon.cycle.clock import Clock
from daemon.cycle.facts import Facts
from daemon.cycle.overrun import OverrunPolicy
from daemon.loop.command import LoopCommand, StartRun
from daemon.loop.controller_port import ControllerPort
from daemon.loop.cycle_schedule import CycleSchedule
from daemon.loop.device_bank import DeviceBank
from daemon.loop.guarded_devices import GuardedDevices
from daemon.loop.loop_statistics import LoopStatistics
from daemon.loop.other_processes import OtherProcesses
from daemon.loop.recording_span import Recording, RecordingSpan
from daemon.modes.mode_keeper import ModeKeeper
from daemon.modes.mode_machine import SAFE_MODES, OperatorAction
from servo_control.signals import Mode


@dataclass(slots=True)
class _PendingCommand:
    """The command that the next cycle acts on. `done`: commands taken so far; `urgent`: somebody waits for its effect."""

    action: OperatorAction = OperatorAction.NONE
    countdown_s: float = 0.0  # of a proof
    done: int = 0
    urgent: bool = False

    def take(self, command: LoopCommand) -> None:
        self.action, self.countdown_s = command.action, command.countdown_s
        self.done += 1
        self.urgent = True


class ControlLoop:
    """One rig's loop. `run` until a command ends it, or `cycle` by cycle, for lockstep. `values`: the facts of the cycle under way."""

    def __init__(self, rig: Rig, facts: Facts, clock: Clock, bank: DeviceBank, others: OtherProcesses, recording: Recording) -> None:
        self._period_ns = round(1e9 / rig.loop.rate_Hz)
        log, overruns = recording.log, OverrunPolicy(self._period_ns, rig.loop.overruns)
        self._clock, self._log, self._overruns = clock, log, overruns
        self._commands, self._health, self._set_points = others.commands, others.health, others.set_points
        self._schedule = CycleSchedule(overruns, recording.timing, clock.start_ns)
        self._statistics = LoopStatistics(facts, log, overruns, recording.timing, 1.0 / rig.loop.rate_Hz)
        self._controller = ControllerPort(rig, facts)
        safe_state = SafeState(rig, bank.drivers, facts, log)
        self._span = span = RecordingSpan(recording, overruns, rig.loop.rate_Hz, safe_state.evidence)
        self.keeper = ModeKeeper(rig, facts, log, 1.0 / rig.loop.rate_Hz, lambda mode: span.open(mode, self._controller))
        self._devices = GuardedDevices(bank, safe_state, self.keeper, span, log)
        self._links = LinkWatch(rig, bank.drivers, facts.indices, log)
        self._watches = watches(rig, facts, lambda family: not family.spare)
        self._spare_watches = watches(rig, facts, lambda family: family.spare)
        self._pending = _PendingCommand()
        self.left = False
        self.values = facts.blank()
        self.values[facts.index("estop_latched")] = 1.0

    def run(self) -> None:
        """Cycle until a command ends the loop. Outputs are safe afterwards in every case; the loop's own exceptions are raised again."""
        self._schedule.begin(self._clock.now_ns() + self._period_ns)
        try:
            while not self.left:
                self.cycle()
        finally:
            self.end()

    def end(self) -> None:
        """Safe outputs, recording closed, devices closed."""
        self._devices.end(self._close_recording)

    def cycle(self) -> None:
        """One cycle. A device that raises is a fault, not the end of the loop."""
        clock, values, deadline = self._clock, self.values, self._schedule.deadline_ns
        started = clock.wait_until(deadline)
        self._devices.read(started, values)
        read = clock.now_ns()
        self._check(deadline, started)
        checked = clock.now_ns()
        self._compute()
        computed = clock.now_ns()
        self._devices.write(self._controller.volts, computed, values)
        written = clock.now_ns()
        self._statistics.measure(values, started - deadline, read - started, computed - read, written - computed)
        self._log.cycle(values)
        recorded = clock.now_ns()
        self._spare(recorded)
        ended = clock.now_ns()
        self._schedule.end(started, read, checked, computed, written, recorded, ended)
        self._statistics.log_overrun(self._schedule.phases_ns, ended)

    def _check(self, deadline: int, started: int) -> None:
        """Facts of this cycle, then the mode."""
        values, keeper, pending = self.values, self.keeper, self._pending
        self._statistics.begin_cycle(values, deadline - self._clock.start_ns, self._clock.start_unix_ns)
        self._health.update(values, started)
        unix_ns = self._log.now_ns
        for watch in self._watches:
            watch.update(values, started, unix_ns)
        self._statistics.count(values, pending.done, started)
        before, action = keeper.mode, pending.action
        pending.action = OperatorAction.NONE
        if action is OperatorAction.RESET:
            action = self._set_up_before_reset()
        mode = keeper.step(values, action, self._overruns.missed_periods)
        if mode is not before:
            self._mode_changed(before, mode)
        self._span.renew(mode, self._controller, keeper.run.active)

    def _set_up_before_reset(self) -> OperatorAction:
        """A reset sets devices up again that have lost their settings. When one refuses it is no reset, and the fault stays."""
        if self.keeper.mode not in SAFE_MODES or not self._devices.needs_setup:
            return OperatorAction.RESET
        self._schedule.activated = True
        are_set_up = self._devices.set_up_again(lambda: self._health.publish(self.values, self._clock.now_ns(), True))
        return OperatorAction.RESET if are_set_up else OperatorAction.NONE

    def _mode_changed(self, before: Mode, mode: Mode) -> None:
        """Recording and outputs follow the mode."""
        self._span.mode_changed()
        self._links.count_soon()
        self._schedule.activated |= mode is Mode.ARMING
        self._devices.mode_changed(before, mode, self.values, self._pending.countdown_s)

    def _compute(self) -> None:
        keeper = self.keeper
        run, point = keeper.run.number_for_controller, self._set_points.take()
        if point is not None and keeper.mode in (Mode.RUNNING, Mode.STOPPING) and point.run == run:
            self._log.set_point(point)
        else:
            point = None  # of a run that is over or has not begun
        outputs = self._controller.step(self.values, keeper.mode, run, point)
        keeper.conditions.finished, keeper.conditions.at_rest = outputs.finished, outputs.stopped

    def _spare(self, now_ns: int) -> None:
        """What may wait until the outputs are written: counts, status, commands, end of a recording."""
        self._links.update(self.values, now_ns)
        unix_ns = self._log.now_ns
        for watch in self._spare_watches:
            watch.update(self.values, now_ns, unix_ns)
        self._statistics.put_run(self.values, self.keeper.run)
        self._health.publish(self.values, now_ns, self._pending.urgent)
        self._pending.urgent = False
        recorded = self._span.follow(self.keeper.mode)
        self.left = recorded and self.keeper.conditions.leaving
        command = self._commands.poll()
        if command is not None:
            self._take(command)

    def _take(self, command: LoopCommand) -> None:
        self._pending.take(command)
        self.keeper.conditions.leaving |= command.leave
        if command.new_recorder:
            self._span.begin_anew()
        if command.start is not None:
            self._prepare(command.start)

    def _prepare(self, start: StartRun) -> None:
        self._controller.prepare(start.plan)
        run = start.plan.run
        self._log.attach(f"run-{run}.json", "application/json", start.request_json.encode())
        self._log.attach(f"maneuver-{run}.yaml", "application/yaml", start.maneuver_yaml.encode())
        self.keeper.request(start.plan, start.countdown_s)

    def _close_recording(self) -> None:
        self._span.close("the loop ended")
        self._log.end()
