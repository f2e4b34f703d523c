"""The whole search as one call: logs and a rig file in, a verdict with its evidence and an improved rig file out.

On files, with findings.json, rig.yaml and report.html written to a folder:

    find(rig: Path | str, logs: Sequence[Path], holdouts: Sequence[Path], out: Path, progress: Progress, settings: Settings) -> Found

On logs in memory, nothing written:

    search_gap(loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], progress: Progress, settings: Settings)

`Found.content` is findings.json as a dictionary. `progress` takes a line of text at a time. For many searches side by side give
`Settings(workers=1, propose=False)` and a process to each search.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from config.errors import LogError, PlantError, UsageError
from config.loading.load import LoadedRig, load_rig
from config.progress import Progress
from config.whole_file import free_name, refuse_unwritable, write_whole
from gap.conclusion import concluded
from gap.data.channel_check import comparable
from gap.data.coarse_steps import CoarseStep, coarse_steps
from gap.data.data_check import DataProblem, check, refuse_pairing, same_maneuver
from gap.data.experiments import experiments_of
from gap.data.log_parts import load_parts
from gap.data.logged_run import given_request
from gap.data.measured import Measured
from gap.data.windows import Experiment
from gap.fitting.evaluation import Evaluation
from gap.fitting.model import Model
from gap.fitting.model_check import against_model
from gap.fitting.nuisance import nuisances
from gap.freed_memory import keep_freed_memory
from gap.judged_file import Searched
from gap.naming import decide
from gap.outcome.file_units import FileUnits
from gap.outcome.findings import as_text
from gap.outcome.found import Found
from gap.outcome.search_state import SearchState, opening_state
from gap.report.report import write_report
from gap.report.unseen import unseen
from gap.settings import Settings

DEFAULTS = Settings()


def find(
    rig: Path | str,
    logs: Sequence[Path],
    holdouts: Sequence[Path],
    out: Path,
    progress: Progress,
    settings: Settings = DEFAULTS,
    unused: Sequence[Path] = (),
) -> Found:
    """Search and write findings.json, rig.yaml and report.html into `out`. LogError (exit 3) for unusable data; what would only be seen
    after minutes, an `out` that takes nothing or a request that is none, is refused before.

    `unused`: logs that neither fit nor decide; the result is judged on them too.
    """
    loaded = load_rig(rig)
    _make_room(out, loaded.path, progress)
    if settings.request is not None:
        given_request(settings.request, [])
    sentences = FileUnits(loaded.text, settings.si).sentences
    try:
        found = search_gap(
            loaded, load_parts(logs, loaded.rig), load_parts(holdouts, loaded.rig), lambda line: progress(sentences.text(line)), settings
        )
    except LogError as refusal:
        raise sentences.refusal(refusal) from refusal
    fresh = unseen(found, unused)
    found.content["unused_logs"] = [item.as_dict() for item in fresh]
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "findings.json", as_text(found.content))
    write_whole(out / "rig.yaml", found.improved_text)
    progress("writing the report")
    write_report(found, out / "report.html", fresh, settings.request, settings.si)
    return found


def _make_room(out: Path, rig: str, progress: Progress) -> None:
    """UsageError where the search's own rig file lies under the name of the improved one, OSError where nothing can be
    written."""
    if (out / "rig.yaml").exists() and Path(rig).exists() and (out / "rig.yaml").samefile(rig):
        advice, mend = "Give another folder for the results.", {"--out": str(free_name(out))}
        raise UsageError("the rig file would be written over by the improved one", where=rig, next_step=advice, mend=mend)
    refuse_unwritable(out)
    if (out / "findings.json").exists():
        progress(f"the results of an earlier search in {out} will be replaced")


def search_gap(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], progress: Progress, settings: Settings = DEFAULTS
) -> Found:
    """The search on logs in memory. Its threads are its own: those of BLAS beside them made one step five times slower."""
    keep_freed_memory()
    with threadpool_limits(limits=1, user_api="blas"):
        return _searched(loaded, fit_logs, holdout_logs, progress, settings)


def _searched(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], progress: Progress, settings: Settings
) -> Found:
    problems = _problems(loaded, fit_logs, holdout_logs, progress)
    fit_logs, holdout_logs = ([comparable(log, loaded.rig) for log in logs] for logs in (fit_logs, holdout_logs))
    logs = [*fit_logs, *holdout_logs]
    names, experiments, held = experiments_of(loaded, fit_logs, holdout_logs, settings)
    model = _opening_model(loaded, names, logs, (experiments, held), progress)
    state = opening_state(model, experiments, held, frozenset(names), progress)
    nominal = state.seen
    faults, decided = _beside_model(nominal, names, progress), None
    if not any(fault.fatal for fault in faults):
        state, decided = decide(loaded, names, state, experiments, progress)
        state = replace(state, coarse=_coarse(loaded, fit_logs, holdout_logs, state))
    return concluded(Searched(loaded, names, state, nominal, [*problems, *faults], logs, settings, progress, decided))


def _problems(loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], progress: Progress) -> list[DataProblem]:
    """Faults of the data that a search can bear. PlantError and LogError for what it cannot."""
    if loaded.rig.plant is None:
        raise PlantError("the rig file has no section 'plant'", where=loaded.path, next_step="The search compares the plant with the logs.")
    refuse_pairing(fit_logs, holdout_logs)
    problems = _checked(loaded, [*fit_logs, *holdout_logs])
    problems += [_repeat(b) for a in fit_logs for b in holdout_logs if same_maneuver(a, b)]
    for problem in problems:
        progress(f"warning: {problem.text()}")
    return problems


def _opening_model(
    loaded: LoadedRig, names: list[str], logs: Sequence[Measured], parts: Sequence[Sequence[Experiment]], progress: Progress
) -> Model:
    """The rig file's plant with the constants that the search may move; says what is compared. `parts`: fitted logs, hold-out."""
    free = nuisances(loaded, frozenset(names))
    for line in in_each(logs, names):
        progress(line)
    windows = " + ".join(str(sum(e.windows for e in part)) for part in parts)
    progress(f"{len(names)} channels, {windows} windows, {len(free)} constants")
    return Model(loaded.rig, free, np.array([item.start for item in free]))


def in_each(logs: Sequence[Measured], names: Sequence[str]) -> list[str]:
    """What is compared, log by log, where they differ."""
    if all(name in log.channels for log in logs for name in names):
        return []
    having = [(log.path.name, [name for name in names if name in log.channels]) for log in logs]
    lacking = [", ".join(name for name in names if name not in found) or "none" for _, found in having]
    return [f"{file}: compared {', '.join(found)}; without {less}" for (file, found), less in zip(having, lacking, strict=True)]


def _checked(loaded: LoadedRig, logs: Sequence[Measured]) -> list[DataProblem]:
    problems = check(logs, loaded.rig)
    fatal = [problem for problem in problems if problem.fatal]
    if fatal:
        more = f" ({len(fatal) - 1} more)" if len(fatal) > 1 else ""
        place = f"{fatal[0].where}: {fatal[0].channel}" if fatal[0].channel else fatal[0].where
        log = fatal[0].where
        every = f"All of it: `longreach log check {shlex.quote(log)} --rig {shlex.quote(loaded.path)}`. " if log.endswith(".mcap") else ""
        advice = f"{every}A good part of the log: {log}@FROM:TO. Columns and units: `longreach import --help`."
        raise LogError(fatal[0].what + more, where=place, next_step=advice)
    return problems


def _coarse(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], state: SearchState
) -> tuple[CoarseStep, ...]:
    """Readings in steps that neither the rig file nor the search has."""
    named = {name.suspect.label for name in state.named}
    found = coarse_steps(fit_logs, holdout_logs, loaded.rig)
    return tuple(item for item in found if f"sensor_quantization at {item.where}" not in named)


def _beside_model(nominal: Sequence[Evaluation], names: list[str], progress: Progress) -> list[DataProblem]:
    """Faults of the data that show beside the simulation of the hold-out."""
    faults = against_model(nominal, names)
    for fault in faults:
        progress(f"{'data problem' if fault.fatal else 'warning'}: {fault.text()}")
    return faults


def _repeat(log: Measured) -> DataProblem:
    what = "has practically the same commands as a fit log: a repeat only tests the noise, log a different maneuver"
    return DataProblem(what, "", str(log.path), False)
