"""Residual vibration of the runs in a folder of logs, measured once a log and kept beside them.

Measuring reads every cycle; the file `.longreach-vibration.json` keeps what was found, for logs that have not changed since. A folder that
cannot be written is measured every time.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from config.errors import LongreachError
from config.whole_file import replaced_when_done
from recording.evaluation.vibration import hold_vibration, rms_mps2
from recording.files.reader import read_log

KEPT = ".longreach-vibration.json"
Residuals = dict[int, float]  # run -> rms of its holds, m/s²


def residual_vibration(logs: Sequence[Path], progress: Callable[[str], None] = lambda line: None) -> dict[Path, Residuals]:
    """Of every log: the rms over the holds of each run of the tip's amplitude 1.0 s after the move, m/s². Runs without such a hold, and
    logs that say nothing about the tip, are left out."""
    found: dict[Path, Residuals] = {}
    for folder in dict.fromkeys(path.parent for path in logs):
        kept = _kept(folder)
        news = {}
        for path in (path for path in logs if path.parent == folder):
            stat = path.stat()
            mark = [stat.st_size, stat.st_mtime_ns]
            entry = kept.get(path.name)
            if entry is None or entry["mark"] != mark:
                progress(f"measuring the vibration in {path.name}")
                news[path.name] = entry = {"mark": mark, "runs": {str(run): value for run, value in _measured(path).items()}}
            found[path] = {int(run): float(value) for run, value in entry["runs"].items()}
        if news:
            _keep(folder, {**kept, **news})
    return found


def _measured(path: Path) -> Residuals:
    try:
        holds = hold_vibration(read_log(path))
    except LongreachError:
        return {}
    return {run: rms_mps2([hold for hold in holds if hold.run == run]) for run in dict.fromkeys(hold.run for hold in holds)}


def _kept(folder: Path) -> dict[str, dict[str, Any]]:
    try:
        content = json.loads((folder / KEPT).read_text())
        return {name: entry for name, entry in content.items() if set(entry) == {"mark", "runs"}}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _keep(folder: Path, content: dict[str, dict[str, Any]]) -> None:
    with contextlib.suppress(OSError), replaced_when_done(folder / KEPT) as temporary:
        temporary.write_text(json.dumps({name: entry for name, entry in content.items() if (folder / name).exists()}))
