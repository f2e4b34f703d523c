"""Trials in a file, so that a matrix too long for one quiet hour can be measured in several."""

from __future__ import annotations

import json
from pathlib import Path

from config.errors import DaemonError
from config.whole_file import replaced_when_done
from daemon.faults.fault import NEVER_MS, FaultRow, FaultTrial


def read(path: Path) -> dict[str, list[FaultTrial]]:
    """Fault name → its trials; nothing when there is no such file. DaemonError when it is no file of trials."""
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {name: [_trial(*numbers) for numbers in trials] for name, trials in content.items()}
    except (ValueError, TypeError, AttributeError) as error:
        advice = "Give another file, or delete it and measure anew."
        raise DaemonError("no file of trials", value=str(error), where=str(path), next_step=advice) from error


def add(path: Path, row: FaultRow) -> None:
    """All trials of a row, instead of those that the file had of this fault."""
    content = {name: [_numbers(trial) for trial in trials] for name, trials in read(path).items()}
    content[row.fault.name] = [_numbers(trial) for trial in row.trials]
    with replaced_when_done(path) as new:
        new.write_text(json.dumps(content, indent=0, ensure_ascii=False), encoding="utf-8")


def _numbers(trial: FaultTrial) -> list[float | str | None]:
    return [trial.time_ms if trial.time_ms != NEVER_MS else None, trial.reaction, trial.reacted_ms]


def _trial(time_ms: float | None, reaction: str, reacted_ms: float | None) -> FaultTrial:
    return FaultTrial(NEVER_MS if time_ms is None else time_ms, reaction, reacted_ms)
