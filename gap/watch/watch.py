"""From a folder of logs and a rig file to what its numbers do over the weeks: a page, and the same as JSON.

    watch(rig: Path | str, logs: Path, out: Path, progress: Progress, since: datetime | None, limits: Sequence[str], workers: int | None)

writes watch.html and watch.json into `out`, and the fit of each log into `out`/logs, where the next call finds it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from config.errors import LogError, PlantError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.progress import Progress
from config.whole_file import whole_file
from gap.executor import each, executor
from gap.fitting.nuisance import nuisances
from gap.outcome.file_units import FileUnits
from gap.settings import PROCESSORS
from gap.watch.dated_logs import DatedLog, Unusable, dated_logs
from gap.watch.followed import Followed, followed
from gap.watch.kept_fits import fitted, kept, key_of
from gap.watch.limits import limits_of
from gap.watch.log_fit import LogFit
from gap.watch.page import watch_page
from gap.watch.watched import watched

KEPT = "logs"


@dataclass(frozen=True, slots=True)
class _Task:
    """One log to fit, in whatever process."""

    folder: Path
    key: str
    log: Path
    rig_text: str
    rig_path: str
    threads: int


@dataclass(frozen=True, slots=True)
class Watch:
    """All that was found; `fits` in the order of time."""

    rig: LoadedRig
    numbers: list[Followed]
    fits: list[tuple[DatedLog, LogFit]]
    unusable: list[Unusable]

    @property
    def alarms(self) -> list[Followed]:
        return [one for one in self.numbers if one.alarm]

    def as_dict(self) -> dict[str, Any]:
        """watch.json, SI."""
        return {
            "rig": self.rig.rig.name,
            "alarms": [one.number.name for one in self.alarms],
            "numbers": {one.number.name: one.as_dict() for one in self.numbers},
            "logs": [{"log": str(log.path), "begun_utc": log.begun.isoformat(), "left": fit.cost} for log, fit in self.fits],
            "unusable": [{"log": str(one.path), "why": one.why, "next_step": one.next_step} for one in self.unusable],
            "software": f"longreach {version('longreach')}",
        }


def watch(
    rig: Path | str,
    logs: Path,
    out: Path,
    progress: Progress,
    since: datetime | None = None,
    limits: Sequence[str] = (),
    workers: int | None = None,
) -> Watch:
    """Fit what is new, say what the numbers do. `limits`: NAME=VALUE each. LogError where no log of the folder can be used."""
    loaded = load_rig(rig)
    if loaded.rig.plant is None:
        raise PlantError("the rig file has no section 'plant'", where=loaded.path, next_step="Its numbers are what is followed.")
    numbers = watched(loaded.rig, nuisances(loaded, frozenset(loaded.rig.plant.sensors)))
    bounds = limits_of(numbers, limits, FileUnits(loaded.text))
    dated, refused = dated_logs(logs, loaded.rig.name)
    late = [log for log in dated if since is None or log.begun >= since]
    fits, unfit = _fits(loaded, late, out / KEPT, progress, workers)
    unusable = sorted([*refused, *unfit], key=lambda one: one.path)
    for one in unusable:
        progress(f"not used: {one.path.name}: {one.why}")
    if not fits:
        raise _no_log(logs, unusable, len(dated) - len(late))
    found = Watch(loaded, followed(numbers, bounds, fits), fits, unusable)
    texts = json.dumps(found.as_dict(), indent=1, allow_nan=False) + "\n", watch_page(loaded, found.numbers, fits, unusable)
    with whole_file(out / "watch.json", "result") as as_data, whole_file(out / "watch.html", "result") as as_page:  # both new, or none
        for place, text in zip((as_data, as_page), texts, strict=True):
            place.write_text(text, encoding="utf-8")
    return found


def _no_log(folder: Path, unusable: Sequence[Unusable], earlier: int) -> LogError:
    """Why none can be used: what --since leaves out, else the first that cannot be. `earlier`: how many began before --since."""
    if earlier:
        what, count = "no log began so late that can be used", f"{earlier} of {earlier + len(unusable)} logs began before --since"
        return LogError(what, value=count, where=str(folder), next_step="Give an earlier --since.", mend={"--since": None})
    first = unusable[0]
    what = f"none of the {len(unusable)} logs can be used; the first: {first.why}"
    return LogError(what, where=str(first.path), next_step=first.next_step)


def run_task(task: _Task) -> LogFit | Unusable:
    loaded = LoadedRig(rig_from_text(task.rig_text, task.rig_path), task.rig_text, task.rig_path)
    return fitted(task.folder, task.key, task.log, loaded, task.threads)


def _fits(
    loaded: LoadedRig, logs: Sequence[DatedLog], folder: Path, progress: Progress, workers: int | None
) -> tuple[list[tuple[DatedLog, LogFit]], list[Unusable]]:
    """Of every log, kept or made."""
    keys, same = _keys(loaded, logs)
    known = {log: found for log, key in keys.items() if (found := kept(folder, key, log.path)) is not None}
    new = [log for log in keys if log not in known]
    progress(f"{len(logs)} logs, {len(known)} fitted before, {len(new)} to fit")
    processes = min(workers or PROCESSORS, len(new))
    threads = max(PROCESSORS // processes, 1) if processes else 1
    tasks = [_Task(folder, keys[log], log.path, loaded.text, loaded.path, threads) for log in new]
    if processes == 1:
        for log, task in zip(new, tasks, strict=True):
            known[log] = run_task(task)
            progress(f"{log.path.name}: {_said(known[log])}")
    elif processes:
        with executor(processes) as pool:
            for done, (number, found) in enumerate(each(pool, run_task, tasks), 1):
                known[new[number]] = found
                progress(f"{done} of {len(new)}: {new[number].path.name}: {_said(found)}")
    fits = [(log, found) for log in keys if isinstance(found := known[log], LogFit)]
    return fits, [*same, *(found for found in known.values() if isinstance(found, Unusable))]


def _keys(loaded: LoadedRig, logs: Sequence[DatedLog]) -> tuple[dict[DatedLog, str], list[Unusable]]:
    """Each log once, however often it lies in the folder."""
    keys: dict[DatedLog, str] = {}
    first: dict[str, DatedLog] = {}
    same = []
    for log in logs:
        key = key_of(log.path, loaded)
        if key in first:
            same.append(Unusable(log.path, f"it is the same as {first[key].path.name}", f"rm {log.path}"))
        else:
            keys[log], first[key] = key, log
    return keys, same


def _said(found: LogFit | Unusable) -> str:
    return f"{len(found.values)} numbers, {found.cost:.3g} noise floors left" if isinstance(found, LogFit) else "not used"
