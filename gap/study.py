"""Many searches at once: one task a pair of logs, run by any executor, one folder of results each and a table of all."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from config.errors import ConfigError, LongreachError
from config.progress import Progress
from gap.executor import each, executor
from gap.find import find


@dataclass(frozen=True, slots=True)
class StudyCase:
    """One search of a study. `name` is its folder's name; paths must mean the same to every worker."""

    name: str
    rig: str
    logs: tuple[str, ...]
    holdouts: tuple[str, ...]
    out: str


def searches(rig: str, pairs: Sequence[tuple[Path, Path]], out: Path) -> list[StudyCase]:
    """One search a pair (log to fit, log that judges), named after the fitted log."""
    names = [fit.stem for fit, _ in pairs]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        advice = "Each pair's folder is named after its first log: rename one."
        raise ConfigError("two pairs would write to one folder", value=", ".join(sorted(twice)), where="--pair", next_step=advice)
    here = str(Path(rig).resolve()) if Path(rig).exists() else rig
    return [
        StudyCase(name, here, (str(fit.resolve()),), (str(held.resolve()),), str((out / name).resolve()))
        for name, (fit, held) in zip(names, pairs, strict=True)
    ]


def run_search(search: StudyCase) -> dict[str, Any]:
    """One task: findings of one search, or why there are none. Writes into its own folder only."""
    try:
        found = find(search.rig, [Path(p) for p in search.logs], [Path(p) for p in search.holdouts], Path(search.out), _silent)
    except LongreachError as refused:
        return {"name": search.name, "verdict": "refused", "why": str(refused), "findings": []}
    return {"name": search.name} | found.content


def run_study(
    todo: Sequence[StudyCase], out: Path, progress: Progress, workers: int | None = None, dask: str | None = None
) -> list[dict[str, Any]]:
    """Run all searches; rows in the order of `todo`, also written to `out`/study.json."""
    out.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Any]] = [{}] * len(todo)
    with executor(workers, dask, progress) as pool:
        for done, (number, row) in enumerate(each(pool, run_search, todo), 1):
            rows[number] = row
            progress(f"{done} of {len(todo)}: {line(row)}")
    part = out / f".study.json.{os.getpid()}"
    part.write_text(json.dumps(rows, indent=2) + "\n")
    os.replace(part, out / "study.json")
    return rows


def line(row: dict[str, Any]) -> str:
    """One search in one line."""
    names = ", ".join(f"{f['effect']} at {f['where']}" for f in row["findings"]) or row.get("why", "")
    return f"{row['name']}: {row['verdict']}: {names}"


def _silent(_: str) -> None:
    return
