"""From a finished search to what is reported: the verdict, the improved rig file on the hold-out, what is left, what was not seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from config.load import LoadedRig
from gap.data.coarse_steps import readable
from gap.data.data_check import DataProblem
from gap.data.measured import Measured
from gap.fitting.evaluation import Evaluation, mean_cost
from gap.fitting.model import Model
from gap.fitting.temperatures import warmings
from gap.maneuvers.doubt import next_of
from gap.report.findings import constants, document, finding, not_seen, step_finding
from gap.report.found import Found
from gap.report.kept_remainder import kept_remainder
from gap.report.localise import localise
from gap.report.model_file import with_step_lines
from gap.report.remainder import remainder, sentence
from gap.report.steadiness import in_words, steadiness, unsteady
from gap.report.written import again, changed, file_model, leanest, text_of, widths_of
from gap.search.candidates import candidates
from gap.search.hold_out_sizes import on_hold_out
from gap.search.screen import screen_sizes
from gap.search.search_state import Search
from gap.search.settings import Settings
from gap.search.verdict import Verdict, channel_rms, confidence, verdict, with_steps
from gap.search.visible import checked
from gap.search.weak_names import weighed

Tell = Callable[[str], None]


def concluded(
    loaded: LoadedRig,
    names: list[str],
    state: Search,
    nominal: tuple[Evaluation, ...],
    problems: list[DataProblem],
    logs: Sequence[Measured],
    settings: Settings,
    tell: Tell,
) -> Found:
    before, refit = mean_cost(nominal), mean_cost(state.constants_only)
    tell("confidence intervals")
    half_width = confidence(state.current, state.costs)
    state.steps = weighed(state, half_width, tell)
    draft = _data_verdict(problems) or verdict(state, before, refit, state.cost)
    widths = widths_of(state, half_width)
    lean = leanest(state, half_width, tell)
    steady = steadiness(state, lean, changed(state.current.model, lean, half_width)) if draft.word == "parameter_mismatch" else []
    text = text_of(loaded, state, draft, lean, widths, before)
    final = nominal if text == loaded.text else again(state, file_model(text))
    after = mean_cost(final)
    word = _data_verdict(problems) or verdict(state, before, refit, after, in_words(unsteady(steady)))
    rest_left = remainder(nominal, final, names, file_model(text).rig) if word.word != "data_problem" else None
    if rest_left and word.word == "unknown":
        word = replace(word, why=f"{word.why} {sentence(rest_left)}")
    text, rest_left = _kept(text, state, rest_left, final, settings, tell)
    places = localise(nominal, names, state.first_screening, loaded.rig)
    _smallest(state, tell)
    found = [finding(state, step, lean, widths, word) for step in state.steps] + [step_finding(item) for item in state.coarse]
    word = with_steps(word, state.coarse)
    text = with_step_lines(text, state.coarse)  # only now: what was judged reads more finely, and the steps count as noise
    parts = {
        "parameters": constants(state.current.model, half_width, steady),
        "gap": _gap(names, nominal, final, refit, logs),
        "remainder": rest_left,
        "not_seen": not_seen(state.screening, {(item["effect"], item["where"]) for item in found}, readable(logs, loaded.rig)),
        "next_maneuver": next_of(loaded, state, word, tell) if settings.propose else None,
        "data": [{"text": problem.text(), "fatal": problem.fatal} for problem in problems],
        "temperatures": _temperatures(state, lean, tell),
    }
    content = document(word, places, found, parts, logs)
    return Found(loaded, names, state, nominal, final, half_width, word, places, problems, text, content)


def _kept(
    text: str, state: Search, rest: dict[str, Any] | None, final: Sequence[Evaluation], settings: Settings, tell: Tell
) -> tuple[str, dict[str, Any] | None]:
    """The file's text, with the remainder in it if it was asked for and is worth it, and the remainder with what became of it."""
    if rest is None or not settings.keep_remainder:
        return text, rest | {"kept": None} if rest else None
    text, kept = kept_remainder(text, state, rest, final, tell)
    return text, rest | {"kept": kept}


def _smallest(state: Search, tell: Tell) -> None:
    """The smallest size of every effect not named that would have been."""
    rest = candidates(state.current.model.rig, state.channels)
    last = screen_sizes(state.current, state.costs, rest, state.seen_at, tell, state.first_screening)
    tell("smallest sizes that would have been named")
    fitted = checked(last, state.current, state.costs, state.seen_at)
    state.screening = on_hold_out(fitted, state.current, state.seen, state.costs, len(rest))


def _gap(
    names: Sequence[str], nominal: tuple[Evaluation, ...], final: tuple[Evaluation, ...], refit: float, logs: Sequence[Measured]
) -> dict[str, Any]:
    """Costs in noise floors, and the error of every channel in its unit, before and after."""
    rms = [channel_rms(evaluations, list(names)) for evaluations in (nominal, final)]
    units = {name: next(log.channels[name].unit for log in logs) for name in names}
    return {
        "unit": "noise floors",
        "holdout_before": mean_cost(nominal),
        "holdout_refit": refit,
        "holdout_after": mean_cost(final),
        "channels": {name: {"before": rms[0][name], "after": rms[1][name], "unit": units[name]} for name in names},
    }


def _data_verdict(problems: Sequence[DataProblem]) -> Verdict | None:
    fatal = [problem.text() for problem in problems if problem.fatal]
    return Verdict("data_problem", f"Nothing is said about the plant: {'; '.join(fatal)}", False) if fatal else None


def _temperatures(state: Search, lean: Model, tell: Tell) -> list[dict[str, object]]:
    """How the oil warms up beside the simulation with the file that is written, hold-out logs only."""
    found = warmings(state.holdouts, lean.vector(), lean.rig)
    for warming in found:
        if not warming.agrees:
            tell(f"temperature: {warming.text()}")
    return [warming.as_dict() for warming in found]
