"""What is in a log, in words: rig, runs and whether each is valid, duration, rate, timing, events."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from config.errors import LogError, UsageError
from recording.files.reader import Log
from recording.files.recordings import asked
from recording.format.event import Event, Level
from recording.format.fields import CYCLE_FIELDS
from servo_control.signals import Mode

ENDED_BEFORE = "the log ends before the run does"
GOES_ON = "the run still goes on, or the log was cut"
_LOOP = {field.name for field in CYCLE_FIELDS}
_IN_MICROSECONDS = "_us"  # histograms and percentiles of the passport: for programs, and the text has them from the cycles


@dataclass(frozen=True, slots=True)
class RunFacts:
    """One run. `reason` says why it is not valid: in the words of the daemon, or as the rows show it when the log was cut."""

    number: int
    maneuver: str
    shaper: str
    start_t_s: float
    duration_s: float
    valid: bool
    reason: str


@dataclass(frozen=True, slots=True)
class LogFacts:
    """`fitted` are the columns that hold numbers; `timing` is made from the cycles, `passport` is what the recorder wrote at close."""

    path: Path
    kind: str
    rig_name: str
    joints: tuple[str, ...]
    about: dict[str, str]
    cycles: int
    first_t_s: float
    last_t_s: float
    duration_s: float
    rate_Hz: float
    bytes_per_s: float
    complete: bool
    cut_text: str
    fitted: tuple[str, ...]
    runs: tuple[RunFacts, ...]
    events: dict[str, int]
    timing: dict[str, str]
    passport: dict[str, str]
    attachments: dict[str, int]

    def text(self) -> str:
        about = ", ".join(f"{key} {value}" for key, value in self.about.items() if value and key not in ("kind", "rig_name"))
        lines = [
            f"{self.path}: {self.kind} log of rig {self.rig_name or 'unknown'}, joints {', '.join(self.joints)}",
            f"  {self.cycles} cycles, {self.duration_s:.3f} s at {self.rate_Hz:.6g} Hz, {self.bytes_per_s / 1e3:.0f} kB/s",
            f"  t_s {self.first_t_s:.3f} to {self.last_t_s:.3f} s",
            f"  {'complete' if self.complete else self.cut_text}",
            f"  {about}",
            f"  columns with numbers: {', '.join(self.fitted)}",
            *(_run_line(run) for run in self.runs),
            f"  events: {_counted(self.events) or 'none'}",
            *(f"  {name}: {value}" for name, value in self.timing.items()),
            *(f"  {name}: {value}" for name, value in self.passport.items() if self._is_told(name)),
            f"  attached: {', '.join(f'{name} ({size / 1000:.1f} kB)' for name, size in self.attachments.items()) or 'nothing'}",
        ]
        return "\n".join(lines)

    def _is_told(self, name: str) -> bool:
        """Of the passport: what the lines above do not say."""
        return not (name in self.timing or name == "rate_Hz" or _IN_MICROSECONDS in name or "histogram" in name)


def describe(log: Log) -> LogFacts:
    """The facts of a log."""
    recording = log.metadata.get("recording", {})
    t = log.columns["t_s"]
    rate_Hz = float(1.0 / np.median(np.diff(t))) if len(t) > 1 else float("nan")
    return LogFacts(
        path=log.path,
        kind=log.kind,
        rig_name=recording.get("rig_name", ""),
        joints=log.layout.joint_names,
        about=recording,
        cycles=log.cycles,
        first_t_s=float(t[0]) if len(t) else float("nan"),
        last_t_s=float(t[-1]) if len(t) else float("nan"),
        duration_s=log.duration_s,
        rate_Hz=rate_Hz,
        bytes_per_s=log.path.stat().st_size / log.duration_s if log.duration_s else float("nan"),
        complete=log.complete,
        cut_text=log.cut_text,
        fitted=tuple(name for name in log.columns if name not in _LOOP and _has_numbers(log, name)),
        runs=tuple(run_facts(log)),
        events=dict(Counter(_level_name(event.level) for event in log.events)),
        timing=_timing(log),
        passport={key: value for key, value in log.metadata.get("closing", {}).items() if key not in ("complete", "cycles")},
        attachments={name: len(data) for name, data in log.attachments.items()},
    )


def run_facts(log: Log) -> list[RunFacts]:
    """Every run that was started in this log, in order."""
    maneuver, mode = log.columns["maneuver"], log.columns["mode"]
    numbers = [int(n) for n in np.unique(maneuver[mode == Mode.RUNNING]) if n]
    return [_run(log, number, np.flatnonzero((maneuver == number) & (mode == Mode.RUNNING))) for number in numbers]


def require_cycles(log: Log, purpose: str = "") -> None:
    """LogError for a log without any. `purpose`: what they are needed for, as "to re-execute"."""
    if not log.cycles:
        what = f"the log holds no cycle {purpose}".rstrip()
        raise LogError(what, where=str(log.path), next_step=f"{asked('check', log.path)} says what is in it.")


def run_of(log: Log, number: int) -> RunFacts:
    """One run. UsageError for a number that the log does not have."""
    runs = {run.number: run for run in run_facts(log)}
    if number not in runs:
        known = ", ".join(map(str, runs)) or "none"
        advice = f"{asked('info', log.path)} shows its runs."
        raise UsageError("the log has no such run", value=number, limit=known, where=str(log.path), next_step=advice)
    return runs[number]


def _run(log: Log, number: int, rows: npt.NDArray[np.intp]) -> RunFacts:
    request = json.loads(log.attachments.get(f"run-{number}.json", b"{}"))
    t = log.columns["t_s"]
    verdict = _daemons_verdict(log, number)
    reason = _why_not_valid(log, rows) if verdict is None else verdict
    return RunFacts(
        number=number,
        maneuver=request.get("maneuver", {}).get("name", "unknown"),
        shaper=request.get("shaper", {}).get("kind", "unknown"),
        start_t_s=float(t[rows[0]]),
        duration_s=float(t[rows[-1]] - t[rows[0]]),
        valid=not reason,
        reason=reason,
    )


def _daemons_verdict(log: Log, number: int) -> str | None:
    """The daemon's own verdict: empty for valid, else its reason; None when the log ends before it."""
    for event in log.events:
        if event.name == "run_ended" and event.values.get("run") == number:
            return why_invalid(event)
    return None


def why_invalid(ended: Event) -> str:
    """What the event `run_ended` says; empty for a valid run."""
    return "" if ended.values.get("valid") else ended.text.partition("because ")[2] or "no reason was given"


def _why_not_valid(log: Log, rows: npt.NDArray[np.intp]) -> str:
    """What the rows say without a verdict; data of another system have no program whose end could be seen."""
    if log.kind == "imported":
        return ""
    first, last = int(rows[0]), int(rows[-1])
    if last + 1 >= log.cycles:
        return ENDED_BEFORE if log.damage.closed else GOES_ON
    after = int(log.columns["mode"][last + 1])
    if after != Mode.HOLDING:
        return {Mode.STOPPING: "stopped", Mode.FAULT: "fault"}.get(Mode(after), f"left for {Mode(after).name.lower()}")
    if log.columns["cycle"][last] - log.columns["cycle"][first] != last - first:
        return "cycles are missing from the log"
    return ""


def _timing(log: Log) -> dict[str, str]:
    """p50, p99 and largest of every phase over the whole log, and what was counted in it."""
    table = {}
    for phase in ("late", "read", "compute", "write"):
        values = log.columns[f"{phase}_us"]
        values = values[np.isfinite(values)]
        if len(values):
            table[f"{phase} p50/p99/max, us"] = f"{np.median(values):.0f}/{np.quantile(values, 0.99):.0f}/{np.max(values):.0f}"
    if log.cycles and table:
        table["overruns"], table["drops"] = str(log.counted("overruns")), str(log.counted("drops"))
    return table


def _has_numbers(log: Log, name: str) -> bool:
    return not name.endswith(("_raw", "_age_s")) and bool(np.any(np.isfinite(log.columns[name])))


def _level_name(level: int) -> str:
    return Level(level).name.lower() if level in set(Level) else str(level)


def _counted(events: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in events.items())


def _run_line(run: RunFacts) -> str:
    verdict = "valid" if run.valid else f"not valid: {run.reason}"
    return f"  run {run.number}: {run.maneuver}, shaper {run.shaper}, from t = {run.start_t_s:.3f} s for {run.duration_s:.3f} s, {verdict}"
