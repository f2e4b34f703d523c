"""What led to a fault, from the log alone: the first cause, what followed in order, what had been asked for, the checks at that moment."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from config.errors import LogError, UsageError
from daemon.checks.check_history import Change, CheckHistory, check_history
from daemon.checks.past_checks import Moment, checks_at
from daemon.modes.mode_keeper import ASKED_FOR
from recording.files.preceding import with_preceding
from recording.files.reader import Log
from recording.files.recordings import asked
from recording.format.event import Event, Level

BEFORE_S = 30.0
AFTER_S = 2.0  # what a recording holds after a fault
FAULT = "fault"
ASKED = ("run_started", "countdown", "set_up")  # events of what was commanded, beside changes of the mode
CHATTER = ("link",)  # once a second, whatever happens


@dataclass(frozen=True, slots=True)
class IncidentStep:
    """Something that happened, `t_s` as in the log. `page`: where it is explained; `bad`: it made things worse."""

    t_s: float
    what: str
    text: str
    bad: bool = False
    page: str = ""


@dataclass(frozen=True, slots=True)
class Incident:
    """One fault of a log. `first` is the check that failed first of those that still failed then; None where no check of the log's columns
    did (an e-stop, a device, a dead process): then the fault's own text is the cause. `log`: with the end of the recording that it
    continues; `row` and `history` count in it. `reaches_back_s`: what it holds before the fault.
    """

    number: int
    log: Log
    fault: Event
    row: int
    first: Change | None
    moment: Moment
    history: CheckHistory
    steps: tuple[IncidentStep, ...]
    commands: tuple[IncidentStep, ...]
    reaches_back_s: float

    @property
    def t_s(self) -> float:
        return self.fault.t_s

    @property
    def cause(self) -> str:
        return self.fault.text if self.first is None else self.first.text

    @property
    def cause_t_s(self) -> float:
        return self.t_s if self.first is None else self.first.t_s


def faults_of(log: Log) -> list[Event]:
    """The faults in a log, in their order."""
    return [event for event in log.events if event.name == FAULT]


def incident_of(log: Log, number: int = 1) -> Incident:
    """Of fault `number`, counted from 1. UsageError where the log holds no such fault, LogError where it holds none or no rig file."""
    fault = _fault(log, number)
    log = with_preceding(log, BEFORE_S)
    t = log.columns["t_s"]
    row = min(int(np.searchsorted(log.columns["cycle"], fault.cycle)), log.cycles - 1)
    start, end = (int(np.searchsorted(t, moment)) for moment in (t[row] - BEFORE_S, t[row] + AFTER_S))
    history = check_history(log, start, min(end, log.cycles - 1))
    span = [event for event in log.events if t[start] <= event.t_s <= t[row] + AFTER_S and event.name not in CHATTER]
    return Incident(
        number=number,
        log=log,
        fault=fault,
        row=row,
        first=None if fault.text.endswith(ASKED_FOR) else _first(history, row),
        moment=checks_at(log, float(t[row])),
        history=history,
        steps=tuple(sorted(_steps(history, span), key=lambda step: step.t_s)),
        commands=tuple(_commands(log, span, fault)),
        reaches_back_s=float(t[row] - t[start]),
    )


def _fault(log: Log, number: int) -> Event:
    faults = faults_of(log)
    if 1 <= number <= len(faults):
        return faults[number - 1]
    advice, where = f"{asked('info', log.path)} shows how each run ended.", str(log.path)
    if not faults:
        raise LogError("the log holds no fault", where=where, next_step=advice)
    raise UsageError("the log holds no such fault", value=number, limit=f"1 to {len(faults)}", where=where, next_step=advice)


def incident_page_of(log: Path, number: int) -> Path:
    """Where the page of a fault stands: beside the log."""
    return log.with_name(f"{log.stem}-incident-{number}.html")


def _first(history: CheckHistory, row: int) -> Change | None:
    """The oldest failure that had not passed again when the fault came. In one cycle the checks' own order decides: causes first."""
    failing: dict[str, Change] = {}
    for change in history.changes:
        if change.row > row:
            break
        if change.ok:
            failing.pop(change.check.name, None)
        else:
            failing[change.check.name] = change
    return min(failing.values(), key=lambda change: change.row, default=None)


def _steps(history: CheckHistory, events: list[Event]) -> Iterator[IncidentStep]:
    """Checks that failed or passed again and what the daemon did about it; of one moment, the checks stand first."""
    for change in history.changes:
        what = f"{change.check.name} {'passes again' if change.ok else 'fails'}"
        yield IncidentStep(change.t_s, what, change.text, not change.ok, change.check.page)
    for event in events:
        yield IncidentStep(event.t_s, event.name, event.text, event.level >= Level.ERROR)


def _commands(log: Log, events: list[Event], fault: Event) -> Iterator[IncidentStep]:
    """What somebody asked for before the fault."""
    for event in events:
        asked = event.name in ASKED or (event.name in ("mode", FAULT) and "asked for" in event.text)
        if asked and event.t_s <= fault.t_s:
            yield IncidentStep(event.t_s, event.name, _with_request(log, event))


def _with_request(log: Log, event: Event) -> str:
    name = f"run-{int(event.values.get('run', 0))}.json"
    if event.name != "run_started" or name not in log.attachments:
        return event.text
    return f"{event.text}: {log.attachments[name].decode(errors='replace')}"
