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
from dataclasses import replace
from pathlib import Path

import numpy as np

from config.errors import LogError, PlantError
from config.load import LoadedRig, load_rig, rig_from_text
from gap.acceptance import REFIT_STEPS
from gap.candidates import candidates
from gap.data_check import DataProblem, censored, check, refuse_pairing, same_maneuver
from gap.doubt import next_of
from gap.evaluation import Evaluation, costing, evaluate, judged, mean_cost
from gap.findings import as_text, constants, document, finding, not_seen
from gap.fit import CONVERGED, Fit, fit, settled, unfitted
from gap.found import Found
from gap.localise import localise
from gap.measured import Array, Measured, compared, load
from gap.model import Model
from gap.model_check import against_model
from gap.model_file import improved, moved, width_key
from gap.noise import noise_floors
from gap.nuisance import nuisances
from gap.remainder import remainder, sentence
from gap.report import write_report
from gap.screen import screen
from gap.search_state import Search
from gap.select import search
from gap.settings import Settings
from gap.simulate import remembering, some
from gap.strata import chosen
from gap.temperatures import warmings
from gap.trial import FLOOR
from gap.unseen import unseen
from gap.verdict import Verdict, channel_rms, confidence, verdict
from gap.visible import checked
from gap.window_length import window_length_s
from gap.windows import Experiment, prepare, velocities
from tuning.record_file import write_whole

DEFAULTS = Settings()
ALIKE = 1.03  # ratio of hold-out costs up to which the model with fewer changes is preferred
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
    names, experiments, held = _experiments(loaded, fit_logs, holdout_logs, settings)
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    tell(f"{len(names)} channels, {sum(e.windows for e in experiments)} + {sum(e.windows for e in held)} windows, {len(free)} constants")
    state, nominal, refitted = _started(model, experiments, held, frozenset(names), tell)
    faults = _beside_model(nominal, names, tell)
    if not any(fault.fatal for fault in faults):
        state = search(state, tell)
    problems += faults
    return _concluded(loaded, names, state, nominal, refitted, problems, [*fit_logs, *holdout_logs], settings, tell)


def _checked(loaded: LoadedRig, logs: Sequence[Measured]) -> list[DataProblem]:
    problems = check(logs, loaded.rig)
    fatal = [problem for problem in problems if problem.fatal]
    if fatal:
        more = f" ({len(fatal) - 1} more)" if len(fatal) > 1 else ""
        place = f"{fatal[0].where}: {fatal[0].channel}" if fatal[0].channel else fatal[0].where
        raise LogError(fatal[0].what + more, where=place, next_step="No verdict about the plant can be given from this log.")
    return problems


def _beside_model(nominal: Sequence[Evaluation], names: list[str], tell: Tell) -> list[DataProblem]:
    """Faults of the data that show beside the simulation of the hold-out."""
    faults = against_model(nominal, names)
    for fault in faults:
        tell(f"{'data problem' if fault.fatal else 'warning'}: {fault.text()}")
    return faults


def _data_verdict(problems: Sequence[DataProblem]) -> Verdict | None:
    fatal = [problem.text() for problem in problems if problem.fatal]
    return Verdict("data_problem", f"Nothing is said about the plant: {'; '.join(fatal)}", False) if fatal else None


def _repeat(log: Measured) -> DataProblem:
    what = "has practically the same commands as a fit log: a repeat only tests the noise, log a different maneuver"
    return DataProblem(what, "", str(log.path), False)


def _experiments(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], settings: Settings
) -> tuple[list[str], list[Experiment], list[Experiment]]:
    """Channels that every log has, cut into windows."""
    every = [*fit_logs, *holdout_logs]
    assert loaded.rig.plant is not None
    sensors = loaded.rig.plant.sensors
    names = [
        name
        for name in compared(every[0].channels, loaded.rig)
        if all(name in log.channels and not censored(log.channels[name], sensors[name].low, sensors[name].high) for log in every)
    ]
    sigma = noise_floors(every, loaded.rig)
    window_s = settings.window_s or window_length_s(loaded.rig, every, sigma)
    cut = [prepare(log, loaded.rig, sigma, window_s, names, settings.workers) for log in every]
    return names, cut[: len(fit_logs)], cut[len(fit_logs) :]


def _started(
    model: Model, experiments: list[Experiment], held: list[Experiment], channels: frozenset[str], tell: Tell
) -> tuple[Search, tuple[Evaluation, ...], tuple[Evaluation, ...]]:
    """The rig file as it is, then with its constants refitted."""
    tell("comparing the rig file with the logs")
    vector, numbers = model.vector(), chosen([velocities(e) for e in experiments])
    few = [remembering(some(e, n), vector) for e, n in zip(experiments, numbers, strict=True)]
    free = [evaluate(e, model, None) for e in (*few, *held)]
    costs = costing([*few, *held], [e.left for e in free])
    counted = [judged(e.experiment, e.readings, e.projection, costs) for e in free]
    now, nominal = counted[: len(few)], tuple(counted[len(few) :])
    tell(f"hold-out: {mean_cost(nominal):.4g} noise floors; sensitivities of {len(model.free)} constants")
    start = unfitted(model, now, costs)
    known = [e.projection for e in now]
    done: Fit = fit(model, few, costs, range(len(model.free)), start.jacobian, REFIT_STEPS, known, CONVERGED)
    few = [remembering(e, done.model.vector()) for e in few]
    again = tuple(evaluate(e, done.model, costs, projection) for e, projection in zip(few, known, strict=True))
    done, costs = settled(replace(done, evaluations=again), few, costs, REFIT_STEPS)
    refitted = tuple(evaluate(e, done.model, costs) for e in held)
    tell(f"hold-out with refitted constants: {mean_cost(refitted):.4g} noise floors")
    return Search(few, held, costs, channels, start, done, refitted, experiments[0].workers), nominal, refitted


def _concluded(
    loaded: LoadedRig,
    names: list[str],
    state: Search,
    nominal: tuple[Evaluation, ...],
    refitted: tuple[Evaluation, ...],
    problems: list[DataProblem],
    logs: Sequence[Measured],
    settings: Settings,
    tell: Tell,
) -> Found:
    before, refit = mean_cost(nominal), mean_cost(refitted)
    draft = _data_verdict(problems) or verdict(state, before, refit, state.cost)
    tell("confidence intervals")
    half_width = confidence(state.current, state.costs)
    widths = _widths(state, half_width)
    lean = _leanest(state, half_width, tell)
    text = _text(loaded, state, draft, lean, widths, before)
    final = nominal if text == loaded.text else _again(state, _file_model(text))
    after = mean_cost(final)
    word = _data_verdict(problems) or verdict(state, before, refit, after)
    rest_left = remainder(nominal, final, names, loaded.rig) if word.word != "data_problem" else None
    if rest_left and word.word == "unknown":
        word = replace(word, why=f"{word.why} {sentence(rest_left)}")
    places = localise(nominal, names, state.first_screening, loaded.rig)
    rest = candidates(state.current.model.rig, state.channels)
    last = screen(state.current, state.costs, rest, state.seen_at, tell, sizes_only=True)
    tell("smallest sizes that would have been named")
    state.screening = checked(last, state.current, state.costs, state.seen_at)
    rms = [channel_rms(evaluations, names) for evaluations in (nominal, final)]
    units = {name: next(log.channels[name].unit for log in logs) for name in names}
    gap = {
        "unit": "noise floors",
        "holdout_before": before,
        "holdout_refit": refit,
        "holdout_after": after,
        "channels": {name: {"before": rms[0][name], "after": rms[1][name], "unit": units[name]} for name in names},
    }
    parts = {
        "parameters": constants(state.current.model, half_width),
        "gap": gap,
        "remainder": rest_left,
        "not_seen": not_seen(state.screening, [s.trial.candidate for s in state.steps]),
        "next_maneuver": next_of(loaded, state, word, tell) if settings.propose else None,
        "data": [{"text": problem.text(), "fatal": problem.fatal} for problem in problems],
        "temperatures": _temperatures(state, lean, tell),
    }
    found = [finding(state, step, lean, widths, word) for step in state.steps]
    content = document(word, places, found, parts, logs)
    return Found(loaded, names, state, nominal, refitted, final, half_width, word, places, problems, text, content)


def _temperatures(state: Search, lean: Model, tell: Tell) -> list[dict[str, object]]:
    """How the oil warms up beside the simulation with the file that is written, hold-out logs only."""
    found = warmings(state.holdouts, lean.vector(), lean.rig)
    for warming in found:
        if not warming.agrees:
            tell(f"temperature: {warming.text()}")
    return [warming.as_dict() for warming in found]


def _widths(state: Search, half_width: Array) -> dict[str, float]:
    """95% half widths of the effects' parameters by name."""
    model = state.current.model
    return {width_key(s, model.free[k].key): float(half_width[k]) for s in state.steps for k in model.of_effect(s.entry)}


def _leanest(state: Search, half_width: Array, tell: Tell) -> Model:
    """The model with the fewest changed constants that predicts the hold-out as well as the one with all of them."""
    model = state.current.model
    effects = [k for entry in model.added for k in model.of_effect(entry)]
    some = sorted({*effects, *moved(model, half_width)})
    for numbers in [effects, some] if effects else [some]:
        smaller = model.restricted(numbers)
        jacobian = [columns[numbers] for columns in state.current.jacobian]
        known = [e.projection for e in state.current.evaluations]
        done = fit(smaller, state.experiments, state.costs, range(len(numbers)), jacobian, 4, known) if numbers else None
        reached = mean_cost(_again(state, done.model)) if done else np.inf
        if done and reached <= max(ALIKE * state.cost, FLOOR):
            tell(f"{len(numbers) - len(effects)} changed constants suffice: hold-out {reached:.4g} noise floors")
            return done.model
    return model


def _text(loaded: LoadedRig, state: Search, draft: Verdict, lean: Model, widths: dict[str, float], before: float) -> str:
    if draft.word in ("no_gap", "data_problem") or (draft.word == "unknown" and not state.steps):
        return loaded.text
    grade = "confirmed" if draft.confirmed else "tentative"
    remark = f"longreach gap find, {grade}: hold-out {before:.4g} to {state.cost:.4g} noise floors"
    return improved(loaded.text, lean, state.steps, widths, remark)


def _file_model(text: str) -> Model:
    """The file as it was written, nothing free: what is reported is what the file does."""
    return Model(rig_from_text(text, "improved rig.yaml"), (), np.empty(0))


def _again(state: Search, model: Model) -> tuple[Evaluation, ...]:
    """A model near the final one on the hold-out, start states taken out as for the final one."""
    return tuple(evaluate(seen.experiment, model, state.costs, seen.projection) for seen in state.seen)
