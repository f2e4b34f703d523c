"""Keeps the mode: gathers the conditions of each cycle, asks the mode machine, and says in an event why a mode changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from config.schema.rig import Rig
from daemon.checks.checks import Check, CheckGroup, Reaction
from daemon.checks.interlocks import interlocks, proof_checks
from daemon.cycle.facts import Facts
from daemon.cycle.log_stream import LogStream
from daemon.modes.mode_machine import Conditions, OperatorAction, update
from daemon.modes.run_watch import RunWatch
from recording.format.event import Level
from servo_control.signals import Mode
from servo_control.streaming.any_plan import AnyPlan

NOT_HOLDING = "not holding"
ASKED_FOR = "was asked for"  # by an operator
ARMING_S = 0.25  # checks must pass this long before the arm holds
_ARMED = (Mode.ARMING, Mode.HOLDING, Mode.RUNNING, Mode.STOPPING)
LONGEST_STOP_S = 5.0  # of a controlled stop; after it the outputs are made safe


class ModeKeeper:
    """`mode` of the cycle under way; `run` is the run that was asked for last."""

    def __init__(self, rig: Rig, facts: Facts, log: LogStream, period_s: float, open_recording: Callable[[Mode], None]) -> None:
        """`open_recording` is called when arming or a proof begins, before the event that says so: the recording begins with it."""
        self.mode = Mode.DISARMED
        self.conditions = Conditions()
        self.run = RunWatch(period_s)
        self.why_fault = ""
        self._why_at_rest = ""  # the check that makes a controlled stop end in a fault
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

    def request(self, plan: AnyPlan, countdown_s: float) -> None:
        """A run whose announcement begins now; the supervisor has checked that none is under way."""
        self._moving = " and ".join(name for name, peaks in zip(plan.joints, plan.peaks, strict=True) if peaks.lowest < peaks.highest)
        self.run.request(plan.run, plan.duration_s, countdown_s)
        self._log_countdown(countdown_s)

    def step(self, values: list[float], action: OperatorAction, missed_periods: int) -> Mode:
        """The mode of this cycle. `values` are its facts, of which only the e-stop latch is set here."""
        if action in (OperatorAction.ESTOP, OperatorAction.RESET):
            values[self._estop] = 1.0 if action is OperatorAction.ESTOP else 0.0
        self._evaluate_checks(values)
        action = self._announce(action)
        before, self.mode = self.mode, update(self.mode, action, self.conditions)
        self._cycles_in_mode += 1
        if self.mode is not before:
            self._changed(before, action, values, missed_periods)
        elif action is OperatorAction.START:
            self._end_run(f"it was not started: {self._failed_stop(values) or 'the daemon ends'}")
        if self.run.follow(self.mode, missed_periods):
            self._log_end_of_run()
        return self.mode

    def fail(self, reason: str) -> None:
        """A fault that no check sees, such as a device that raised."""
        before, self.mode = self.mode, Mode.FAULT
        if before is not Mode.FAULT:
            self._log_fault(before, reason)
            self.run.invalidate(f"fault: {reason}")
        if self.run.follow(self.mode, 0):
            self._log_end_of_run()

    def _evaluate_checks(self, values: list[float]) -> None:
        now = self.conditions
        for reaction, group in self._groups.items():
            self._failed[reaction] = group.first_failed(values)
        now.fault = self._failed[Reaction.FAULT] is not None
        now.stop = self._failed[Reaction.STOP] is not None
        now.fault_at_rest = self._faults_at_rest(values)
        now.checks_pass = not (now.fault or now.stop or now.fault_at_rest or self._failed[Reaction.REFUSE])
        now.may_prove = self._for_proof.first_failed(values) is None
        now.settled = self._cycles_in_mode >= self._arming_cycles
        now.overdue = self._cycles_in_mode > self._longest_stop_cycles

    def _faults_at_rest(self, values: list[float]) -> bool:
        """Latched while a stop is under way and in the cycle after it: a check that passes again does not call off the fault."""
        failed = self._failed[Reaction.STOP_THEN_FAULT]
        if self.conditions.fault_at_rest and self.mode in (Mode.STOPPING, Mode.HOLDING):
            return True
        if failed is not None and self.mode in _ARMED:
            self._why_at_rest = failed.sentence(values)
        return failed is not None

    def _announce(self, action: OperatorAction) -> OperatorAction:
        """Count down to motion. The action START is made here and nowhere else."""
        if not self.run.active or self.run.countdown_cycles == 0:
            return action
        if action is not OperatorAction.NONE or self.mode is not Mode.HOLDING:
            self._end_run(f"{action.name.lower()} was asked for before it began" if action else self._not_holding())
            return action
        left_s = self.run.count_down()
        if left_s == 0:
            return OperatorAction.START
        if left_s is not None:
            self._log_countdown(left_s)
        return OperatorAction.NONE

    def _not_holding(self) -> str:
        """Of a run that arrives when the mode has just changed."""
        because = f": {self.why_fault}" if self.mode is Mode.FAULT and self.why_fault else ""
        return f"it was not started: the mode was {self.mode.name.lower()}, {NOT_HOLDING}{because}"

    def _log_countdown(self, left_s: float) -> None:
        text = f"run {self.run.number}: motion of {self._moving or 'no joint'} starts in {left_s:g} s"
        self._log.event(Level.INFO, "countdown", text, {"run": self.run.number, "countdown_s": left_s})

    def _changed(self, before: Mode, action: OperatorAction, values: list[float], missed_periods: int) -> None:
        reason = self._reason(before, action, values)
        self._cycles_in_mode = 0
        if self.mode in (Mode.ARMING, Mode.PROVING):
            self._open_recording(self.mode)
        if self.mode is Mode.FAULT:
            self._log_fault(before, reason)
        else:
            because = f": {reason}" if reason else ""
            self._log.event(Level.INFO, "mode", f"{before.name.lower()} → {self.mode.name.lower()}{because}", {"mode": self.mode})
        if self.mode is Mode.ARMING:
            self._warn(values)
        if self.mode is Mode.RUNNING:
            self.run.begin(missed_periods)
            self._log.event(Level.INFO, "run_started", f"run {self.run.number} moves", {"run": self.run.number})
        elif not (before is Mode.RUNNING and self.mode is Mode.HOLDING):
            self.run.invalidate(f"fault: {reason}" if self.mode is Mode.FAULT else reason)

    def _reason(self, before: Mode, action: OperatorAction, values: list[float]) -> str:
        """Why the mode changed: the first cause that holds."""
        causes = self._causes_of_end(action, values) if before is Mode.PROVING else self._causes(before, action, values)
        return next(filter(None, causes), "")

    def _causes(self, before: Mode, action: OperatorAction, values: list[float]) -> Iterator[str]:
        """Most serious first, in the order in which the mode machine decides."""
        if action is OperatorAction.ESTOP:
            yield _asked(action)
        if self.mode is Mode.FAULT:
            yield self._sentence(Reaction.FAULT, values)
        if self.mode is Mode.FAULT and before is Mode.STOPPING and self.conditions.overdue:
            yield f"the controlled stop took longer than {LONGEST_STOP_S:g} s"
        if action in (OperatorAction.STOP, OperatorAction.DISARM, OperatorAction.RESET):
            yield _asked(action)
        if before is Mode.ARMING:  # given up: by what refuses only arming, else by what would also stop a run
            yield self._sentence(Reaction.REFUSE, values)
        if before is Mode.ARMING or self.mode in (Mode.STOPPING, Mode.FAULT):
            yield self._failed_stop(values)
        if self.conditions.leaving:
            yield "the daemon ends"

    def _causes_of_end(self, action: OperatorAction, values: list[float]) -> Iterator[str]:
        """Of a proof."""
        if action is OperatorAction.ESTOP:
            yield _asked(action)
        failed = self._for_proof.first_failed(values)
        if failed is not None:
            yield f"the proof was given up: {failed.sentence(values)}"
        if self.conditions.proof_over:
            yield "the proof is over"
        yield _asked(action) if action else "the daemon ends"

    def _warn(self, values: list[float]) -> None:
        """The log names what was armed in spite of."""
        for check in self._groups[Reaction.WARN].failed(values):
            self._log.event(Level.WARNING, "check", check.sentence(values))

    def _failed_stop(self, values: list[float]) -> str:
        return (self._why_at_rest if self.conditions.fault_at_rest else "") or self._sentence(Reaction.STOP, values)

    def _sentence(self, reaction: Reaction, values: list[float]) -> str:
        check = self._failed[reaction]
        return check.sentence(values) if check else ""

    def _log_fault(self, before: Mode, reason: str) -> None:
        self.why_fault = reason
        self._log.event(Level.FAULT, "fault", reason, {"mode_before": before})

    def _end_run(self, reason: str) -> None:
        self.run.invalidate(reason)
        self.run.end()
        self._log_end_of_run()

    def _log_end_of_run(self) -> None:
        run = self.run
        level, verdict = (Level.WARNING, f"invalid, because {run.reason}") if run.reason else (Level.INFO, "valid")
        self._log.event(level, "run_ended", f"run {run.number}: {verdict}", {"run": run.number, "valid": float(not run.reason)})


def _asked(action: OperatorAction) -> str:
    name = "e-stop" if action is OperatorAction.ESTOP else action.name.lower()
    return f"{name} {ASKED_FOR}"
