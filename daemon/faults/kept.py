"""Trials in a file, so that a matrix too long for one quiet hour can be measured in several."""

from __future__ import annotations

import json
from pathlib import Path

from config.errors import DaemonError
from daemon.faults.fault import NEVER_MS, Row, Trial


def read(path: Path) -> dict[str, list[Trial]]:
    """Fault name → its trials; nothing when there is no such file. DaemonError when it is no file of trials."""
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return {name: [_trial(*numbers) for numbers in trials] for name, trials in content.items()}
    except (ValueError, TypeError, AttributeError) as error:
        advice = "Give another file, or delete it and measure anew."
        raise DaemonError("no file of trials", value=str(error), where=str(path), next_step=advice) from error


def add(path: Path, row: Row) -> None:
    """All trials of a row, in place of what the file had of this fault."""
    content = {name: [_numbers(trial) for trial in trials] for name, trials in read(path).items()}
    content[row.fault.name] = [_numbers(trial) for trial in row.trials]
    new = path.with_name(f"{path.name}.new")
    new.write_text(json.dumps(content, indent=0, ensure_ascii=False), encoding="utf-8")
    new.rename(path)


def _numbers(trial: Trial) -> list[float | str | None]:
    return [trial.time_ms if trial.time_ms != NEVER_MS else None, trial.reaction, trial.reacted_ms]


def _trial(time_ms: float | None, reaction: str, reacted_ms: float | None) -> Trial:
    return Trial(NEVER_MS if time_ms is None else time_ms, reaction, reacted_ms)
