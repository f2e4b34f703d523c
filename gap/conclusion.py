"""From a finished search to what is reported: the verdict, the improved rig file on the hold-out, what is left, what was not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from config.progress import Progress
from gap.data.coarse_steps import readable
from gap.data.measured import Array
from gap.fitting.common_scale import at_own_scale
from gap.fitting.confidence import confidence
from gap.fitting.evaluation import channel_rms, mean_cost
from gap.fitting.model import Model
from gap.fitting.temperatures import warmings
from gap.judged_file import JudgedFile, Searched, judged_file
from gap.maneuvers.doubt import next_of
from gap.outcome.findings import by_fit_logs, constants, document, finding, not_seen, step_finding
from gap.outcome.found import Found
from gap.outcome.held_constants import held_constants
from gap.outcome.localise import Disagreement, localise
from gap.outcome.model_file import with_step_lines
from gap.outcome.names import Fitted
from gap.outcome.search_state import SearchState
from gap.outcome.stated_zeros import stated_zeros
from gap.outcome.verdict import Verdict, with_steps
from gap.outcome.written import again

Content = dict[str, Any]  # a part of findings.json


def concluded(done: Searched) -> Found:
    """The verdict with everything that report, findings file and improved rig file need."""
    done, half_width = _with_intervals(done)
    judged = judged_file(done, half_width)
    places = _places(done, judged.word)
    state, progress = done.state, done.progress
    found, leads = _findings(done, judged, half_width)
    word = with_steps(judged.word, state.coarse)
    text = with_step_lines(judged.text, state.coarse)  # only now: what was judged reads more finely, and the steps count as noise
    progress(said(word, found))
    parts = {"leads": leads, **_parts(done, judged, word, [*found, *leads], half_width)}
    content = document(word, places, found, parts, done.logs)
    return Found(
        rig=done.loaded,
        channels=done.names,
        state=state,
        nominal=done.nominal,
        final=judged.file.seen,
        half_width=half_width,
        verdict=word,
        places=places,
        problems=done.problems,
        improved_text=text,
        content=content,
        with_all_logs=judged.all_logs.seen if judged.all_logs else None,
    )


def _with_intervals(done: Searched) -> tuple[Searched, Array]:
    """The search at the common scale, and the 95 % half width of every free number; infinite where nothing could be fitted."""
    if done.decided is None:
        return done, np.full(len(done.state.nominal.free), np.inf)
    state = _at_own_scale(done.state)
    done.progress("confidence intervals")
    return replace(done, state=state), np.maximum(confidence(state.current, state.costs), done.decided.half_width)


def _places(done: Searched, word: Verdict) -> list[Disagreement]:
    """Where something acts that cannot be named; else where the rig file and the hold-out disagree."""
    if done.decided and done.decided.places and word.word == "unknown":
        return list(done.decided.places)
    return localise(done.nominal, done.names, next(iter(done.state.named), None), done.loaded.rig)


def _at_own_scale(state: SearchState) -> SearchState:
    fitted = at_own_scale(state.current, state.costs)
    return state if fitted is state.current else replace(state, current=fitted, seen=again(state, fitted.model))


def _findings(done: Searched, judged: JudgedFile, half_width: Array) -> tuple[list[Content], list[Content]]:
    """What the written file has, and what helped but left too much to be named."""
    state, steps = done.state, [step_finding(item) for item in done.state.coarse]
    by_fit = Fitted(state.current.model, half_width)
    found = [finding(name, done.decided.chosen, by_fit) for name in state.named] if done.decided else []
    return (steps, found) if judged.word.word == "unknown" else ([*found, *steps], [])


def _constants(done: Searched, judged: JudgedFile, half_width: Array) -> Content:
    """Those of the file that is written; where all logs have fitted it, the fit logs' beside them."""
    by_fit = constants(done.state.current.model, half_width, judged.file.model, judged.steady)
    if judged.all_logs is None or done.decided is None:
        return by_fit
    fitted = done.decided.written
    final = constants(fitted.model, fitted.half_width, judged.all_logs.model, judged.steady)
    return {key: item | (by_fit_logs(by_fit[key]) if key in by_fit else {}) for key, item in final.items()}


def _parts(done: Searched, judged: JudgedFile, word: Verdict, told: Sequence[Content], half_width: Array) -> Content:
    """What findings.json holds beside the findings. `told`: findings and leads."""
    state, loaded, progress, logs = done.state, done.loaded, done.progress, done.logs
    told_of = {(item["effect"], item["where"]) for item in told}
    return {
        "rig": loaded.rig.name,
        "parameters": _constants(done, judged, half_width),
        "gap": _gap(done, judged),
        "judge": [one.as_dict() for one in done.decided.said.judge] if done.decided else [],
        "held": _held(done, word, told),
        "remainder": judged.rest,
        "not_seen": not_seen(done.decided.least if done.decided else (), told_of, readable(logs, loaded.rig)),
        "next_maneuver": next_of(loaded, state, progress) if done.settings.propose else None,
        "data": [{"text": problem.text(), "fatal": problem.fatal} for problem in done.problems],
        "temperatures": _temperatures(state, judged.written.model, progress),
    }


def _held(done: Searched, word: Verdict, told: Sequence[Content]) -> list[Content]:
    """Constants that no fit may move and that the logs want elsewhere, those that the file states as 0 first."""
    if word.word in ("no_gap", "data_problem"):
        return []
    loaded, state, progress = done.loaded, done.state, done.progress
    zeros = stated_zeros(loaded, state, told, progress)
    known = {item.free.key for item in zeros}
    others = [item for item in held_constants(loaded, state, progress) if item.free.key not in known]
    return [item.as_dict() for item in (*zeros, *others)]


def said(word: Verdict, findings: Sequence[Content]) -> str:
    """The verdict in a line, before any maneuver is looked for: that may take minutes."""
    sizes = [", ".join(f"{key} {p['value']:.4g} {p['unit']}".strip() for key, p in item["parameters"].items()) for item in findings]
    names = [f"{item['effect']} at {item['where']} ({size})" for item, size in zip(findings, sizes, strict=True)]
    return f"verdict: {word.word}" + (f": {'; '.join(names)}" if names else "")


def _gap(done: Searched, judged: JudgedFile) -> Content:
    """Costs in noise floors, and the error of every channel in its unit, before and after."""
    final, all_logs = judged.file.seen, judged.all_logs
    rms = [channel_rms(evaluations, list(done.names)) for evaluations in (done.nominal, final)]
    names = [name for name in done.names if all(np.isfinite(side[name]) for side in rms)]  # a hold-out may lack what a fit log has
    units = {name: next(log.channels[name].unit for log in done.logs if name in log.channels) for name in names}
    return {
        "unit": "noise floors",
        "holdout_before": mean_cost(done.nominal),
        "holdout_refit": done.refit,
        "holdout_after": mean_cost(final),
        **({"holdout_all_logs": all_logs.cost} if all_logs else {}),
        "channels": {name: {"before": rms[0][name], "after": rms[1][name], "unit": units[name]} for name in names},
    }


def _temperatures(state: SearchState, lean: Model, progress: Progress) -> list[dict[str, object]]:
    """How the oil warms up beside the simulation with the file that is written, hold-out logs only."""
    found = warmings(state.holdouts, lean.vector(), lean.rig)
    for warming in found:
        if not warming.agrees:
            progress(f"temperature: {warming.text()}")
    return [warming.as_dict() for warming in found]
