"""Holds the mode: gathers the conditions of each cycle, asks the mode machine, and says in an event why a mode changed."""

from __future__ import annotations

from collections.abc import Callable

from config.rig import Rig
from control.run_plan import RunPlan
from control.signals import Mode
from daemon.checks import Check, CheckGroup, Reaction
from daemon.facts import Facts
from daemon.interlocks import interlocks, proof_checks
from daemon.log_stream import LogStream
from daemon.modes import Conditions, Event, update
from daemon.run_watch import RunWatch
from recording.event import Level

ARMING_S = 0.25  # checks must pass this long before the arm holds
LONGEST_STOP_S = 5.0  # of a controlled stop; after it the outputs are made safe


class ModeKeeper:
    """`mode` of the cycle under way; `run` is the run that was asked for last."""

    def __init__(self, rig: Rig, facts: Facts, log: LogStream, period_s: float, open_recording: Callable[[Mode], None]) -> None:
        """`open_recording` is called when arming or a proof begins, before that is told, so that the log begins with it."""
        self.mode = Mode.DISARMED
        self.conditions = Conditions()
        self.run = RunWatch(period_s)
        self.why_fault = ""
        self._log = log
        self._open_recording = open_recording
        self.checks = interlocks(rig, facts)
        self._groups = {reaction: CheckGroup(each for each in self.checks if each.reaction is reaction) for reaction in Reaction}
        self._for_proof = CheckGroup(proof_checks(rig, facts))
        self._failed: dict[Reaction, Check | None] = dict.fromkeys(Reaction)
        self._estop = facts.index("estop_latched")
        self._arming_cycles = round(ARMING_S / period_s)
        self._longest_stop_cycles = round(LONGEST_STOP_S / period_s)
        self._cycles_in_mode = 0
        self._moving = ""

    def request(self, plan: RunPlan, countdown_s: float) -> None:
        """A run whose announcement begins now; the supervisor has checked that none is under way."""
        self._moving = " and ".join(name for name, peaks in zip(plan.joints, plan.peaks, strict=True) if peaks.lowest < peaks.highest)
        self.run.request(plan.run, plan.duration_s, countdown_s)
        self._tell_countdown(countdown_s)

    def step(self, values: list[float], event: Event, missed_periods: int) -> Mode:
        """The mode of this cycle. `values` are its facts, of which only the e-stop latch is set here."""
        if event in (Event.ESTOP, Event.RESET):
            values[self._estop] = 1.0 if event is Event.ESTOP else 0.0
        self._look(values)
        event = self._announce(event)
        before, self.mode = self.mode, update(self.mode, event, self.conditions)
        self._cycles_in_mode += 1
        if self.mode is not before:
            self._changed(before, event, values, missed_periods)
        elif event is Event.START:
            self._end_run(f"it was not started: {self._failed_stop(values) or 'the daemon ends'}")
        if self.run.follow(self.mode, missed_periods):
            self._tell_end()
        return self.mode

    def fail(self, reason: str) -> None:
        """A fault that no check sees, such as a device that raised."""
        before, self.mode = self.mode, Mode.FAULT
        if before is not Mode.FAULT:
            self._tell_fault(before, reason)
            self.run.spoil(f"fault: {reason}")
        if self.run.follow(self.mode, 0):
            self._tell_end()

    def _look(self, values: list[float]) -> None:
        now = self.conditions
        for reaction, group in self._groups.items():
            self._failed[reaction] = group.first_failed(values)
        now.fault = self._failed[Reaction.FAULT] is not None
        now.stop = self._failed[Reaction.STOP] is not None
        now.fault_at_rest = self._failed[Reaction.STOP_THEN_FAULT] is not None
        now.checks_pass = not (now.fault or now.stop or now.fault_at_rest or self._failed[Reaction.REFUSE])
        now.may_prove = self._for_proof.first_failed(values) is None
        now.settled = self._cycles_in_mode >= self._arming_cycles
        now.overdue = self._cycles_in_mode > self._longest_stop_cycles

    def _announce(self, event: Event) -> Event:
        """Motion is announced every second; the event of its beginning is made here and nowhere else."""
        if not self.run.active or self.run.countdown_cycles == 0:
            return event
        if event is not Event.NONE or self.mode is not Mode.HOLDING:
            asked = f"{event.name.lower()} was asked for before it began"
            self._end_run(asked if event else f"the daemon was {self.mode.name.lower()}, not holding")
            return event
        left_s = self.run.count_down()
        if left_s == 0:
            return Event.START
        if left_s is not None:
            self._tell_countdown(left_s)
        return Event.NONE

    def _tell_countdown(self, left_s: float) -> None:
        text = f"run {self.run.number}: motion of {self._moving or 'no joint'} starts in {left_s:g} s"
        self._log.event(Level.INFO, "countdown", text, {"run": self.run.number, "countdown_s": left_s})

    def _changed(self, before: Mode, event: Event, values: list[float], missed_periods: int) -> None:
        reason = self._reason(before, event, values)
        self._cycles_in_mode = 0
        if self.mode in (Mode.ARMING, Mode.PROVING):
            self._open_recording(self.mode)
        if self.mode is Mode.FAULT:
            self._tell_fault(before, reason)
        else:
            because = f": {reason}" if reason else ""
            self._log.event(Level.INFO, "mode", f"{before.name.lower()} → {self.mode.name.lower()}{because}", {"mode": self.mode})
        if self.mode is Mode.ARMING:
            self._warn(values)
        if self.mode is Mode.RUNNING:
            self.run.begin(missed_periods)
            self._log.event(Level.INFO, "run_started", f"run {self.run.number} moves", {"run": self.run.number})
        elif not (before is Mode.RUNNING and self.mode is Mode.HOLDING):
            self.run.spoil(f"fault: {reason}" if self.mode is Mode.FAULT else reason)

    def _reason(self, before: Mode, event: Event, values: list[float]) -> str:
        """Why the mode changed, most serious first."""
        if event is Event.ESTOP:
            return "e-stop was asked for"
        if before is Mode.PROVING:
            return self._reason_of_end(event, values)
        if self.mode is Mode.FAULT and self.conditions.fault:
            return self._sentence(Reaction.FAULT, values)
        if self.mode is Mode.FAULT and self.conditions.overdue and before is Mode.STOPPING:
            return f"the controlled stop took longer than {LONGEST_STOP_S:g} s"
        if event in (Event.STOP, Event.DISARM, Event.RESET):
            return f"{event.name.lower()} was asked for"
        if before is Mode.ARMING and (sentence := self._sentence(Reaction.REFUSE, values)):
            return sentence
        tripped = self.mode in (Mode.STOPPING, Mode.FAULT) or before is Mode.ARMING
        if tripped and (sentence := self._failed_stop(values)):
            return sentence
        return "the daemon ends" if self.conditions.leaving else ""

    def _reason_of_end(self, event: Event, values: list[float]) -> str:
        """Of a proof."""
        failed = self._for_proof.first_failed(values)
        if failed is not None:
            return f"the proof was given up: {failed.sentence(values)}"
        return "the proof is over" if self.conditions.proof_over else f"{event.name.lower()} was asked for" if event else "the daemon ends"

    def _warn(self, values: list[float]) -> None:
        """What arming goes on in spite of stands in the log."""
        for check in self._groups[Reaction.WARN].failed(values):
            self._log.event(Level.WARNING, "check", check.sentence(values))

    def _failed_stop(self, values: list[float]) -> str:
        return self._sentence(Reaction.STOP_THEN_FAULT, values) or self._sentence(Reaction.STOP, values)

    def _sentence(self, reaction: Reaction, values: list[float]) -> str:
        check = self._failed[reaction]
        return check.sentence(values) if check else ""

    def _tell_fault(self, before: Mode, reason: str) -> None:
        self.why_fault = reason
        self._log.event(Level.FAULT, "fault", reason, {"mode_before": before})

    def _end_run(self, reason: str) -> None:
        self.run.spoil(reason)
        self.run.end()
        self._tell_end()

    def _tell_end(self) -> None:
        run = self.run
        level, verdict = (Level.WARNING, f"invalid, because {run.reason}") if run.reason else (Level.INFO, "valid")
        self._log.event(level, "run_ended", f"run {run.number}: {verdict}", {"run": run.number, "valid": float(not run.reason)})
