"""When a recording begins and ends.

One covers the time from arming until the outputs no longer act, and a little longer after a fault; a long one is cut between two runs,
because a file's index grows with it and because a file is what gets sent. A proof of the safe state has one of its own. Between these,
where the daemon runs as a service, the rows go on in standby recordings, cut every ten minutes, of which only the newest are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from daemon.cycle.log_stream import LogStream
from daemon.cycle.overrun import OverrunPolicy
from daemon.cycle.timing import Timing, passport
from daemon.loop.controller_port import ControllerPort
from servo_control.signals import Mode

FAULT_TAIL_S = 2.0
STANDBY_S = 600.0  # length of one standby recording
ARMED_S = 1800.0  # an armed recording is cut when the arm holds still after this
OUTPUTS_ACT = (Mode.ARMING, Mode.HOLDING, Mode.RUNNING, Mode.STOPPING)
_RECORDED = (*OUTPUTS_ACT, Mode.PROVING)
_SPANS = {Mode.ARMING: "armed", Mode.PROVING: "proof"}


@dataclass(frozen=True, slots=True)
class Recording:
    """What a loop records with. `entries` go into every recording's metadata: what the operating system granted.

    `standby`: also record while the outputs do not act.
    """

    log: LogStream
    timing: Timing
    entries: Mapping[str, str] = field(default_factory=dict)
    standby: bool = False


class RecordingSpan:
    """Opens and closes the log's recordings; the timing passport covers exactly one of them.

    `evidence`: what else every recording gets, by name, as JSON.
    """

    def __init__(self, recording: Recording, overruns: OverrunPolicy, rate_Hz: float, evidence: Callable[[], Mapping[str, bytes]]) -> None:
        self._log, self._timing, self._entries, self._standby = recording.log, recording.timing, dict(recording.entries), recording.standby
        self._overruns, self._rate_Hz, self._evidence = overruns, rate_Hz, evidence
        self._in_standby = False
        self._left = 0  # cycles until this recording is cut
        self._tail = 0
        self._mark()

    def open(self, mode: Mode, controller: ControllerPort) -> None:
        """Call in the first cycle of arming or proving, before the controller steps: its state now is what re-execution starts from."""
        self._open(_SPANS[mode], ARMED_S, controller)

    def renew(self, mode: Mode, controller: ControllerPort, in_run: bool) -> None:
        """Once a cycle, before the controller steps: see to it that the row of this cycle has a recording, and not too long a one.

        `in_run`: a run is announced or under way; its request stands in this recording, so it ends here too.
        """
        self._left -= 1
        if self._left >= 0:
            return
        if mode is Mode.HOLDING and not in_run:
            self._open("armed", ARMED_S, controller)
        elif self._standby and mode not in _RECORDED and (not self._log.recording or self._in_standby):
            self._open("standby", STANDBY_S, controller)

    def _open(self, span: str, length_s: float, controller: ControllerPort) -> None:
        self.close("continued in the next recording" if self._in_span(span) else span)
        self._in_standby = span == "standby"
        self._left = round(length_s * self._rate_Hz)
        self._mark()
        self._timing.clear()
        self._log.open(controller.snapshot(), {"span": span, **self._entries})
        for name, content in self._evidence().items():
            self._log.attach(name, "application/json", content)

    def _in_span(self, span: str) -> bool:
        return self._log.recording and self._in_standby == (span == "standby")

    def begin_anew(self) -> None:
        """The recorder knows of no recording: where one is due, the next row begins it."""
        self.close("the recorder was started again")
        self._left = 0

    def mode_changed(self) -> None:
        self._tail = round(FAULT_TAIL_S * self._rate_Hz)

    def follow(self, mode: Mode) -> bool:
        """Once a cycle, after its row was sent: True while nothing keeps the loop from ending."""
        if mode in _RECORDED:
            return False
        if self._in_standby:
            return True
        if mode is Mode.FAULT and self._tail > 0:
            self._tail -= 1
            return False
        self.close("fault" if mode is Mode.FAULT else "disarmed")
        self._left = 0
        return True

    def close(self, ended_by: str) -> None:
        """End the recording, if there is one, with its timing passport."""
        if not self._log.recording:
            return
        overruns = self._overruns
        culprits = {phase: count - self._overruns_before[phase] for phase, count in overruns.by_culprit.items()}
        cycles = self._log.cycle_number - self._cycle_before
        entries = passport(self._timing, culprits, overruns.missed_periods - self._missed_before, cycles, self._rate_Hz)
        self._in_standby = False
        self._log.close({"ended_by": ended_by, "drops": str(self._log.drops_in_recording), **entries, **self._entries})

    def _mark(self) -> None:
        self._overruns_before = dict(self._overruns.by_culprit)
        self._missed_before = self._overruns.missed_periods
        self._cycle_before = self._log.cycle_number
