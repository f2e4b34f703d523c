"""The whole search as one call: logs and a rig file in, a verdict with its evidence and an improved rig file out.

On files, with findings.json, rig.yaml and report.html written to a folder:

    find(rig: Path | str, logs: Sequence[Path], holdouts: Sequence[Path], out: Path, tell: Tell, settings: Settings) -> Found

On logs in memory, nothing written:

    search_gap(loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], tell: Tell, settings: Settings) -> Found

`Found.content` is findings.json as a dictionary. `tell` takes progress lines. For many searches side by side give
`Settings(workers=1, propose=False)` and a process to each search.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from config.errors import LogError, PlantError
from config.load import LoadedRig, load_rig
from gap.conclusion import concluded
from gap.data.coarse_steps import CoarseStep, coarse_steps
from gap.data.data_check import DataProblem, check, refuse_pairing, same_maneuver
from gap.data.measured import Measured, load
from gap.fitting.evaluation import Evaluation
from gap.fitting.model import Model
from gap.fitting.model_check import against_model
from gap.fitting.nuisance import nuisances
from gap.report.findings import as_text
from gap.report.found import Found
from gap.report.report import write_report
from gap.report.unseen import unseen
from gap.search.last_look import last_look
from gap.search.opening import experiments_of, started
from gap.search.search_state import Search
from gap.search.settings import Settings
from gap.search.together import look_together
from gap.search.within_priors import look_within_priors, search_within_priors
from tuning.record_file import write_whole

DEFAULTS = Settings()
Tell = Callable[[str], None]


def find(
    rig: Path | str,
    logs: Sequence[Path],
    holdouts: Sequence[Path],
    out: Path,
    tell: Tell,
    settings: Settings = DEFAULTS,
    unused: Sequence[Path] = (),
) -> Found:
    """Search and write findings.json, rig.yaml and report.html into `out`. LogError (exit 3) for unusable data.

    `unused`: logs that neither fit nor decide; the result is judged on them too.
    """
    loaded = load_rig(rig)
    found = search_gap(loaded, [load(p, loaded.rig) for p in logs], [load(p, loaded.rig) for p in holdouts], tell, settings)
    fresh = unseen(found, unused)
    found.content["unused_logs"] = [item.as_dict() for item in fresh]
    out.mkdir(parents=True, exist_ok=True)
    write_whole(out / "findings.json", as_text(found.content))
    write_whole(out / "rig.yaml", found.improved_text)
    tell("writing the report")
    write_report(found, out / "report.html", fresh, settings.request)
    return found


def search_gap(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], tell: Tell, settings: Settings = DEFAULTS
) -> Found:
    """The search on logs in memory."""
    if loaded.rig.plant is None:
        raise PlantError("the rig file has no section 'plant'", where=loaded.path, next_step="The search compares the plant with the logs.")
    refuse_pairing(fit_logs, holdout_logs)
    problems = _checked(loaded, [*fit_logs, *holdout_logs])
    problems += [_repeat(b) for a in fit_logs for b in holdout_logs if same_maneuver(a, b)]
    for problem in problems:
        tell(f"warning: {problem.text()}")
    names, experiments, held = experiments_of(loaded, fit_logs, holdout_logs, settings)
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    tell(f"{len(names)} channels, {sum(e.windows for e in experiments)} + {sum(e.windows for e in held)} windows, {len(free)} constants")
    state, nominal = started(model, experiments, held, frozenset(names), tell)
    faults = _beside_model(nominal, names, tell)
    if not any(fault.fatal for fault in faults):
        state = look_together(search_within_priors(state, tell), tell)
        state = last_look(look_within_priors(state, tell), tell)
        state.coarse = _coarse(loaded, fit_logs, holdout_logs, state)
    problems += faults
    return concluded(loaded, names, state, nominal, problems, [*fit_logs, *holdout_logs], settings, tell)


def _checked(loaded: LoadedRig, logs: Sequence[Measured]) -> list[DataProblem]:
    problems = check(logs, loaded.rig)
    fatal = [problem for problem in problems if problem.fatal]
    if fatal:
        more = f" ({len(fatal) - 1} more)" if len(fatal) > 1 else ""
        place = f"{fatal[0].where}: {fatal[0].channel}" if fatal[0].channel else fatal[0].where
        raise LogError(fatal[0].what + more, where=place, next_step="No verdict about the plant can be given from this log.")
    return problems


def _coarse(loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], state: Search) -> tuple[CoarseStep, ...]:
    """Readings in steps that neither the rig file nor the search has."""
    named = {step.trial.candidate.label for step in state.steps}
    found = coarse_steps(fit_logs, holdout_logs, loaded.rig)
    return tuple(item for item in found if f"sensor_quantization at {item.where}" not in named)


def _beside_model(nominal: Sequence[Evaluation], names: list[str], tell: Tell) -> list[DataProblem]:
    """Faults of the data that show beside the simulation of the hold-out."""
    faults = against_model(nominal, names)
    for fault in faults:
        tell(f"{'data problem' if fault.fatal else 'warning'}: {fault.text()}")
    return faults


def _repeat(log: Measured) -> DataProblem:
    what = "has practically the same commands as a fit log: a repeat only tests the noise, log a different maneuver"
    return DataProblem(what, "", str(log.path), False)
