"""Is a log fit for use? A list of named findings, each with what was seen and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from config.errors import LongreachError
from config.schema.rig import Rig
from recording.files.reader import Log, open_rig, read_log
from recording.format.fields import field_of_signal
from servo_control.signals import Mode

Grade = Literal["ok", "warning", "error"]
_LOST_SHARE = 0.01  # samples of a required signal that may be lost now and then
_OWN_ATTACHMENTS = ("rig.yaml", "calibration.json", "foxglove_layout.json", "controller_state.json")


@dataclass(frozen=True, slots=True)
class LogFinding:
    """One check. `name` is stable, for programs; `text` is for people."""

    name: str
    grade: Grade
    text: str


@dataclass(frozen=True, slots=True)
class CheckReport:
    path: Path
    findings: tuple[LogFinding, ...]

    @property
    def good(self) -> bool:
        """No finding is an error."""
        return all(finding.grade != "error" for finding in self.findings)

    def text(self) -> str:
        lines = [f"{finding.grade:8}{finding.name:14}{finding.text}" for finding in self.findings]
        return "\n".join([f"{self.path}: {'good' if self.good else 'not good'}", *lines])


def check_log(path: str | Path, rig: Rig | None = None) -> CheckReport:
    """All checks on one log. With `rig`, also whether the log is of that rig. Raises LogError when it cannot be read at all."""
    return checked(read_log(path), rig)


def checked(log: Log, rig: Rig | None = None) -> CheckReport:
    """The same of a log that is read already."""
    findings = [_whole(log), _attachments(log), _runs(log)]
    if log.cycles:
        findings += [_cycles(log), _time(log), _drops(log), _late(log), *_required_signals(log)]
    else:
        findings.append(LogFinding("cycles", "error", "there is no cycle in it"))
    if rig is not None:
        findings.append(_same_rig(log, rig))
    return CheckReport(log.path, tuple(findings))


def _whole(log: Log) -> LogFinding:
    if log.complete:
        return LogFinding("whole", "ok", "closed in order, every checksum is right")
    repaired = "recovered" in log.metadata and not log.damage.sentences
    return LogFinding("whole", "warning" if repaired else "error", log.cut_text)


def _attachments(log: Log) -> LogFinding:
    if log.kind == "imported":
        return LogFinding("attachments", "ok", f"data of another system, imported from {log.metadata['recording'].get('source', '?')}")
    missing = [name for name in _OWN_ATTACHMENTS if name not in log.attachments]
    missing += [f"metadata {name}" for name in ("recording",) if name not in log.metadata]
    if missing:
        return LogFinding("attachments", "error", f"missing: {', '.join(missing)}; the log cannot be re-executed from itself")
    return LogFinding("attachments", "ok", "rig, calibration, viewer layout and controller state are inside")


def _runs(log: Log) -> LogFinding:
    numbers = [int(n) for n in np.unique(log.columns["maneuver"]) if n]
    wanted = [name for n in numbers for name in (f"run-{n}.json", f"maneuver-{n}.yaml")]
    missing = [name for name in wanted if name not in log.attachments]
    if missing and log.kind != "imported":
        return LogFinding("runs", "error", f"missing: {', '.join(missing)}")
    return LogFinding("runs", "ok", f"{len(numbers)} run{'s' * (len(numbers) != 1)}")


def _cycles(log: Log) -> LogFinding:
    steps = np.diff(log.columns["cycle"].astype(np.int64))
    wrong = np.flatnonzero(steps != 1)
    if not len(wrong):
        return LogFinding("cycles", "ok", f"{log.cycles} cycles, none missing")
    first = wrong[0]
    lost = int(np.sum(steps[steps > 1] - 1))
    where = f"first after cycle {log.columns['cycle'][first]} at t = {log.columns['t_s'][first]:.3f} s"
    return LogFinding("cycles", "error", f"{lost} cycles missing in {len(wrong)} places, {where}")


def _time(log: Log) -> LogFinding:
    t = log.columns["t_s"]
    bad = np.flatnonzero(~(np.diff(t) > 0))
    if len(bad) or not np.all(np.isfinite(t)):
        row = int(bad[0]) + 1 if len(bad) else int(np.flatnonzero(~np.isfinite(t))[0])
        return LogFinding("time", "error", f"time does not increase at row {row}: {t[max(row - 1, 0)]!s} s, then {t[row]!s} s")
    period = float(np.median(np.diff(t))) if len(t) > 1 else float("nan")
    skipped = int(np.sum(np.maximum(0, np.round(np.diff(t) / period) - 1))) if len(t) > 1 else 0
    grade: Grade = "warning" if skipped else "ok"
    return LogFinding("time", grade, f"{log.duration_s:.3f} s, median period {period * 1e3:.4g} ms, {skipped} periods skipped")


def _drops(log: Log) -> LogFinding:
    drops = int(log.metadata.get("closing", {}).get("drops", log.counted("drops")))
    return LogFinding("drops", "error" if drops else "ok", f"{drops} records did not reach the log")


def _late(log: Log) -> LogFinding:
    late = log.columns["late_us"][np.isfinite(log.columns["late_us"])]
    overruns = log.counted("overruns")
    if not len(late):
        return LogFinding("timing", "ok", "no timing was recorded")
    grade: Grade = "warning" if overruns else "ok"
    return LogFinding("timing", grade, f"late p50 {np.median(late):.0f} us, p99 {np.quantile(late, 0.99):.0f} us; {overruns} overruns")


def _required_signals(log: Log) -> Iterator[LogFinding]:
    """NaN in a required signal while the rig was armed; without a rig file, joints that have no position at all."""
    try:
        signals = [name for name, signal in open_rig(log).signals.items() if signal.required]
    except LongreachError as error:
        if "rig.yaml" in log.attachments:
            yield LogFinding("rig", "error", str(error))
        signals = [f"{joint}.position" for joint in log.layout.joint_names]
    armed = np.isin(log.columns["mode"], (Mode.HOLDING, Mode.RUNNING, Mode.STOPPING)) | (log.kind == "imported")
    bad = {name: int(np.sum(np.isnan(_column_of(log, name)[armed]))) for name in signals}
    rows = int(np.sum(armed))
    holes = [f"{field_of_signal(name)} in {count} of {rows} rows" for name, count in bad.items() if count]
    grade: Grade = "error" if max(bad.values(), default=0) > _LOST_SHARE * rows else "warning"
    if holes:
        yield LogFinding("signals", grade, "NaN (sensor not fitted or failed) while armed: " + ", ".join(holes))
    else:
        yield LogFinding("signals", "ok", f"all {len(signals)} required signals are there")


def _column_of(log: Log, signal: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    absent = np.full(log.cycles, np.nan)
    return np.asarray(log.columns.get(field_of_signal(signal), absent), dtype=np.float64)


def _same_rig(log: Log, rig: Rig) -> LogFinding:
    name = log.metadata.get("recording", {}).get("rig_name", "unknown")
    joints = tuple(rig.joints)
    if name != rig.name or log.layout.joint_names != joints:
        seen = f"the log is of rig {name} with joints {', '.join(log.layout.joint_names)}"
        return LogFinding("rig", "error", f"{seen}; the rig given is {rig.name} with joints {', '.join(joints)}")
    return LogFinding("rig", "ok", f"of rig {name}")
