"""The control loop: wait → read → checks and mode → controller → write → record, at a fixed rate, on either clock.

Clock, devices, commands, health and log are given from outside, so lockstep and wall clock run the same code. Every way out of
`run` makes the outputs safe. In a cycle: plain floats, no lock, no wait but the clock's, nothing that grows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from config.rig import Rig
from control.signals import Mode
from daemon.calibration_watch import CalibrationWatch
from daemon.clock import Clock
from daemon.command import NOT_SET_UP, CommandSource, StartRun
from daemon.controller_port import ControllerPort
from daemon.device_bank import DeviceBank
from daemon.facts import Facts
from daemon.link_watch import LinkWatch
from daemon.log_stream import LogStream
from daemon.loop_numbers import LoopNumbers
from daemon.mode_keeper import ModeKeeper
from daemon.modes import SAFE_MODES, Event
from daemon.overrun import PHASES, OverrunPolicy
from daemon.plausibility import Plausibility
from daemon.recording_span import OUTPUTS_ACT, RecordingSpan
from daemon.safe_state import SafeState
from daemon.swing import Swing
from daemon.timing import Timing
from recording.event import Level


class Surroundings(Protocol):
    """What the loop hears of the other processes, and what they hear of it; called once a cycle, never waits."""

    def update(self, values: list[float], now_ns: int) -> None:
        """Put the facts about recorder, disk and supervisor into `values`."""

    def publish(self, values: list[float], now_ns: int, urgent: bool) -> None:
        """Show the facts of this cycle; `urgent` after a change somebody waits for."""


class ControlLoop:
    """One rig's loop. `run` until told to leave; or `cycle` by cycle, for lockstep."""

    def __init__(
        self,
        rig: Rig,
        facts: Facts,
        clock: Clock,
        bank: DeviceBank,
        commands: CommandSource,
        log: LogStream,
        surroundings: Surroundings,
        timing: Timing,
        loop_facts: Mapping[str, str] | None = None,
        standby: bool = False,
    ) -> None:
        """`loop_facts` go into every recording: what the operating system granted. `standby`: record also while disarmed."""
        self._clock, self._bank, self._commands, self._log = clock, bank, commands, log
        self._surroundings, self._timing = surroundings, timing
        self._period_ns = round(1e9 / rig.loop.rate_Hz)
        self._overruns = OverrunPolicy(self._period_ns, rig.loop.overruns)
        self._numbers = LoopNumbers(facts, log, self._overruns, timing, 1.0 / rig.loop.rate_Hz)
        self._controller = ControllerPort(rig, facts)
        self._plausibility = Plausibility(rig, facts)
        self._span = RecordingSpan(log, timing, self._overruns, rig.loop.rate_Hz, loop_facts or {}, standby)
        self.keeper = ModeKeeper(rig, facts, log, 1.0 / rig.loop.rate_Hz, lambda mode: self._span.open(mode, self._controller))
        self._links = LinkWatch(rig, bank.drivers, facts.places, log)
        self._calibrations = CalibrationWatch(rig, facts, log)
        self._swing = Swing(rig, facts)
        self._safe_state = SafeState(rig, bank.drivers, facts, log)
        self._span.evidence = self._safe_state.evidence
        self._countdown_s = 0.0  # of a proof that was asked for
        self.values = facts.blank()
        self.values[facts.index("estop_latched")] = 1.0
        self._event = Event.NONE
        self.left = False
        self._phases_ns = [0] * len(PHASES)
        self._deadline_ns = self._end_ns = clock.start_ns
        self._commands_done = 0
        self._urgent = self._activated = self._device_told = False

    def run(self) -> None:
        """Cycle until told to leave. Outputs are safe afterwards, whatever happened; an exception of the loop itself is raised again."""
        self._deadline_ns = self._end_ns = self._clock.now_ns() + self._period_ns
        try:
            while not self.left:
                self.cycle()
        finally:
            self.end()

    def end(self) -> None:
        """Safe outputs, recording closed, devices given back."""
        self._safe_state.give_up()
        try:
            self._bank.safe()
        finally:
            self._span.close("the loop ended")
            self._log.end()
            self._bank.close()

    def cycle(self) -> None:
        """One cycle. A device that raises is a fault, not the end of the loop."""
        clock, phases, deadline = self._clock, self._phases_ns, self._deadline_ns
        before = max(deadline, self._end_ns)
        started = clock.wait_until(deadline)
        read = self._read(started)
        self._check(deadline, started)
        checked = clock.now_ns()
        self._compute()
        computed = clock.now_ns()
        self._write(computed)
        written = clock.now_ns()
        self._numbers.measure(self.values, started - deadline, read - started, computed - read, written - computed)
        self._log.cycle(self.values)
        recorded = clock.now_ns()
        self._spare(recorded)
        end = clock.now_ns()
        phases[:] = (
            started - before,
            read - started,
            checked - read,
            computed - checked,
            written - computed,
            recorded - written,
            end - recorded,
        )
        self._timing.count(4, (end - started) * 1e-3)
        self._end_ns = end
        if self._activated:
            self._activated = False
            self._deadline_ns = self._overruns.deadline_after_activation(deadline, end)
            return
        self._deadline_ns = self._overruns.next_deadline(deadline, end, phases)
        self._numbers.tell_overrun(phases, end)

    def _read(self, started: int) -> int:
        try:
            self._bank.read(started, self.values)
        except Exception as error:  # whatever a driver raises: its inputs are unknown, so outputs become safe
            self._device_failed("read", error)
        self._safe_state.follow(self.values)
        return self._clock.now_ns()

    def _check(self, deadline: int, started: int) -> None:
        """Facts of this cycle, then the mode."""
        values, keeper = self.values, self.keeper
        self._numbers.begin_cycle(values, deadline - self._clock.start_ns, self._clock.start_unix_ns)
        self._surroundings.update(values, started)
        self._plausibility.update(values, started)
        self._numbers.count(values, self._commands_done, started)
        before, event = keeper.mode, self._event
        self._event = Event.NONE
        event = self._set_up_before_reset(event)
        mode = keeper.step(values, event, self._overruns.missed_periods)
        if mode is not before:
            self._mode_changed(before, mode)
        self._span.renew(mode, self._controller)

    def _set_up_before_reset(self, event: Event) -> Event:
        """A reset sets devices up again that have lost their settings. When one refuses it is no reset, and the fault stays."""
        if event is not Event.RESET or self.keeper.mode not in SAFE_MODES or not self._bank.needs_setup:
            return event
        self._activated = True
        try:
            self._bank.set_up_again(lambda: self._surroundings.publish(self.values, self._clock.now_ns(), True))
        except Exception as error:  # whatever a driver raises
            self._log.event(Level.ERROR, NOT_SET_UP, f"a device could not be set up again: {error}")
            self.keeper.fail(f"a device refused its settings: {error}")
            return Event.NONE
        self._log.event(Level.INFO, "set_up", "the devices were set up again, read back and compared")
        return event

    def _mode_changed(self, before: Mode, mode: Mode) -> None:
        """Recording and outputs follow the mode."""
        self._span.mode_changed()
        self._links.look_soon()
        self._device_told = False
        if mode is Mode.ARMING:
            self._activated = True
            self._guarded("activate", self._bank.activate)
        elif mode is Mode.PROVING:
            self.keeper.conditions.proof_over = False
            self._safe_state.begin(self.values, self._countdown_s)
        elif before is Mode.PROVING:
            self._safe_state.give_up()
            self._guarded("safe", self._bank.safe)
        elif mode not in OUTPUTS_ACT and before in OUTPUTS_ACT:
            self._guarded("safe", self._bank.safe)

    def _compute(self) -> None:
        keeper = self.keeper
        outputs = self._controller.step(self.values, keeper.mode, keeper.run.number_for_controller)
        keeper.conditions.finished, keeper.conditions.at_rest = outputs.finished, outputs.stopped

    def _write(self, now_ns: int) -> None:
        mode = self.keeper.mode
        try:
            if mode in OUTPUTS_ACT:
                self._bank.write(self._controller.volts, now_ns)
            elif mode is Mode.PROVING:
                self._safe_state.step(self.values)
                self.keeper.conditions.proof_over = self._safe_state.over
        except Exception as error:  # whatever a driver raises
            self._device_failed("write" if mode is not Mode.PROVING else "the proof", error)

    def _spare(self, now_ns: int) -> None:
        """What may wait until the outputs are written: counts, status, commands, end of a recording."""
        self._links.update(self.values, now_ns)
        self._calibrations.update(self.values, now_ns)
        self._swing.update(self.values)
        self._numbers.tell_run(self.values, self.keeper.run)
        self._surroundings.publish(self.values, now_ns, self._urgent)
        self._urgent = False
        recorded = self._span.follow(self.keeper.mode)
        self.left = recorded and self.keeper.conditions.leaving
        command = self._commands.poll()
        if command is None:
            return
        self._commands_done += 1
        self._urgent = True
        self._event, self._countdown_s = command.event, command.countdown_s
        self.keeper.conditions.leaving |= command.leave
        if command.start is not None:
            self._prepare(command.start)

    def _prepare(self, start: StartRun) -> None:
        self._controller.prepare(start.plan)
        run = start.plan.run
        self._log.attach(f"run-{run}.json", "application/json", start.request_json.encode())
        self._log.attach(f"maneuver-{run}.yaml", "application/yaml", start.maneuver_yaml.encode())
        self.keeper.request(start.plan, start.countdown_s)

    def _device_failed(self, verb: str, error: Exception) -> None:
        if self.keeper.mode is not Mode.FAULT:
            self._span.mode_changed()
        self.keeper.fail(f"a device refused {verb}: {error}")
        self._safe_state.give_up()
        self._guarded("safe", self._bank.safe)

    def _guarded(self, verb: str, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:  # whatever a driver raises, perhaps in every cycle from now on
            if not self._device_told:
                self._log.event(Level.ERROR, "device", f"a device refused {verb}: {error}")
            self._device_told = True
            self.keeper.fail(f"a device refused {verb}: {error}")
