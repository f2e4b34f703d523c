"""The search by evidence in the place of the search by gates: the same state for outcome and report, and what is said of it.

`gap.evidence` finds the most probable set and its neighbours. Here that becomes models on all windows, trials beside the best one, and a
verdict with probabilities. A number of the rig file that has changed is no effect to be added: it is written as a constant, and its finding
says what was `stated` and the `value` now. Values are those of all logs, as the file is written; those of the fit logs stand beside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from config.loading.load import LoadedRig
from config.progress import Progress
from config.schema.effect_library import EFFECTS
from gap.all_logs import Fitted, as_constants, as_fit, half_width, on_all_logs
from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.judgement.votes import Votes
from gap.evidence.judgement.words import Alike, Name, Said, said
from gap.evidence.noise.uncut import uncut
from gap.evidence.opening import opening
from gap.evidence.score.changed import Changed
from gap.evidence.score.hypothesis import Hypothesis, beyond
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import STAGES
from gap.evidence.visible_sizes import visible_sizes
from gap.fitting.compare import paired_t
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.fit import Fit
from gap.fitting.model import Model
from gap.outcome.findings import LeastSize, by_fit_logs, number
from gap.outcome.localise import Disagreement
from gap.outcome.unexplained import in_words, where_unexplained
from gap.search.search_state import GateSearch, Step
from gap.search.trial import FLOOR, Trial
from gap.search.verdict import Verdict
from gap.signatures.candidates import Candidate


@dataclass(frozen=True, slots=True)
class Decided:
    """What the evidence says beside the state that it was put into. `half_width`: 95 %, of every free number of the chosen model, by the
    fit logs. `chosen`: that set fitted to all logs; `alone`: constants alone by the fit logs, and fitted to all, where no name is to be
    written."""

    said: Said
    half_width: Array
    chosen: Fitted
    alone: tuple[Model, Fitted] | None
    changes: tuple[dict[str, Any], ...]  # findings: numbers of the rig file that have changed
    least: tuple[LeastSize, ...]  # of every suspect beside the chosen set, what the fit logs would have shown
    places: tuple[Disagreement, ...]  # where the chosen set, on all logs, leaves more than honest models leave

    @property
    def written(self) -> Fitted:
        """What the file is written with."""
        return self.alone[1] if self.alone else self.chosen

    @property
    def verdict(self) -> Verdict:
        return Verdict(self.said.word, f"{self.said.why}{in_words(self.places)}", self.said.confirmed)

    def with_probability(self, item: dict[str, Any]) -> dict[str, Any]:
        """A finding with its probability, and its look-alikes with their shares."""
        name = next((n for n in self.said.names if n.suspect.label == f"{item['effect']} at {item['where']}"), None)
        if name is None:
            return item
        fitted = {f"{rival['effect']} at {rival['where']}": rival for rival in item["look_alikes"]}
        alike = [_rival(other) | fitted.get(other.label, {}) for other in name.alike]
        said = {"probability": _short(name.probability), "confirmed": name.confirmed, "look_alikes": alike}
        return item | said | _voted(name.votes)


def by_evidence(
    loaded: LoadedRig, names: Sequence[str], state: GateSearch, experiments: Sequence[Experiment], progress: Progress
) -> tuple[GateSearch, Decided]:
    """`state`: with its constants refitted; `experiments`: the fit logs, whole."""
    search = opening(loaded.rig, state.nominal.model.free, experiments, names)
    for stage in STAGES:
        search = stage(search, progress)
    outcome = said(search, [uncut(e, loaded.rig, names) for e in state.holdouts], names)
    best, null = _whole(state, outcome.chosen), _whole(state, search.null)
    without = {n.suspect.label: search.known(outcome.chosen.labels - {n.suspect.label}) or search.null for n in outcome.names}
    bases = [(n, _whole(state, without[n.suspect.label])) for n in outcome.names]
    steps = [_step(state, search, outcome.chosen, n, best, base) for n, base in bases if isinstance(n.suspect, Candidate)]
    blind = Fitted(outcome.chosen.model, half_width(search.seen, outcome.chosen))
    chosen = on_all_logs(state, outcome.all_logs, outcome.on_all[outcome.chosen.labels])
    changes = tuple(_changed(blind, chosen, n, best, base) for n, base in bases if isinstance(n.suspect, Changed))
    progress("smallest sizes that would have been named")
    least, places = _least(search, outcome), _places(state, outcome, names, loaded)
    alone = _alone(state, search, outcome)
    state = replace(state, current=best[0], seen=best[1], constants_only=null[1], steps=tuple(steps))
    return state, Decided(outcome, blind.half_width, chosen, alone, changes, least, places)


def _places(state: GateSearch, outcome: Said, names: Sequence[str], loaded: LoadedRig) -> tuple[Disagreement, ...]:
    """Where the chosen set, fitted to all logs, leaves more than honest models leave."""
    chosen = outcome.on_all[outcome.chosen.labels]
    over = beyond(outcome.all_logs, chosen)
    if not over.any():
        return ()
    done = as_fit(chosen, [*state.experiments, *state.holdouts], state.costs)
    left = [replace(e, experiment=own) for e, own in zip(done.evaluations, outcome.all_logs.experiments, strict=True)]
    return tuple(where_unexplained(left, chosen.at.discrepancy, over, names, loaded.rig))


def _least(search: EvidenceSearch, outcome: Said) -> tuple[LeastSize, ...]:
    """Sizes at which the others would have been as probable as not, by the fit logs: the hold-out proposes no name."""
    chosen = outcome.chosen
    found = visible_sizes(search.seen, chosen, search.suspects_beside(chosen), -search.log_odds)
    stated = [s.suspect.free.start if isinstance(s.suspect, Changed) else None for s in found]
    return tuple(LeastSize(s.suspect.effect, s.suspect.where, s.parameter, s.unit, s.size, at) for s, at in zip(found, stated, strict=True))


def _alone(state: GateSearch, search: EvidenceSearch, outcome: Said) -> tuple[Model, Fitted] | None:
    """Constants alone, by the fit logs and by all, where there are names and none is to be written."""
    if outcome.word != "unknown" or not outcome.names:
        return None
    return as_constants(search.null), on_all_logs(state, outcome.all_logs, outcome.on_all[search.null.labels])


Whole = tuple[Fit, tuple[Evaluation, ...]]  # a model on the fit logs and on the hold-out


def _whole(state: GateSearch, hypothesis: Hypothesis) -> Whole:
    """The model as the fit logs have it, in the costs of the report."""
    done = as_fit(hypothesis, state.experiments, state.costs)
    return done, tuple(evaluate(e, done.model, state.costs) for e in state.holdouts)


def _step(state: GateSearch, search: EvidenceSearch, chosen: Hypothesis, name: Name, best: Whole, base: Whole) -> Step:
    """One name as an accepted effect, its look-alikes as its rivals."""
    assert isinstance(name.suspect, Candidate)
    own = name.suspect
    rest, rivals = chosen.labels - {own.label}, []
    for other in name.alike:
        rival = search.known(rest | {other.label})
        suspect = next((s for s in rival.suspects if s.label == other.label), None) if rival else None
        if rival and isinstance(suspect, Candidate):
            rivals.append(_trial(suspect, _whole(state, rival), base))
    entry = next(e for e in chosen.model.added if (e.effect, e.where) == (own.effect, own.where))
    weak = "" if name.confirmed else f"has a probability of {name.probability:.3g}"
    return Step(entry, _trial(own, best, base), tuple(rivals), (), weak)


def _trial(candidate: Candidate, whole: Whole, base: Whole) -> Trial:
    drop = mean_cost(base[1]) - mean_cost(whole[1])
    return Trial(candidate, whole[0], whole[1], _gain(whole, base), drop, paired_t(base[1], whole[1]), True)


def _gain(whole: Whole, base: Whole) -> float:
    """Share of the hold-out's excess over the floor that is taken away."""
    before = mean_cost(base[1])
    return (before - mean_cost(whole[1])) / max(before - FLOOR, 1e-9)


def _changed(blind: Fitted, chosen: Fitted, name: Name, best: Whole, base: Whole) -> dict[str, Any]:
    """The finding of a number that has changed, of the chosen set as the fit logs have it and as all logs do."""
    assert isinstance(name.suspect, Changed)
    free = name.suspect.free
    at = next(k for k, f in enumerate(chosen.model.free) if f.key == free.key)
    by_fit, by_all = (number(float(one.model.theta[at]), float(one.half_width[at]), free.unit) for one in (blind, chosen))
    effect = EFFECTS.get(name.suspect.effect)
    return {
        "effect": name.suspect.effect,
        "where": name.suspect.where,
        "confirmed": name.confirmed,
        "probability": _short(name.probability),
        "stated": _short(free.start),
        "value": by_all["value"],
        "parameters": {free.key.rpartition(".")[2]: by_all | by_fit_logs(by_fit)},
        "holdout_gain": _short(_gain(best, base)),
        "t": _short(paired_t(base[1], best[1])),
        "look_alikes": [_rival(other) for other in name.alike],
        "fingerprint": effect.fingerprint if effect else "",
        "equation": effect.search.equation if effect and effect.search else "",
        **_voted(name.votes),
    }


def _voted(votes: Votes | None) -> dict[str, Any]:
    """What either log says of a name, the other one fitted (ln)."""
    return {"votes": {"holdout": _short(votes.holdout), "fit_logs": _short(votes.fit_logs)}} if votes else {}


def _rival(other: Alike) -> dict[str, Any]:
    effect, _, where = other.label.partition(" at ")
    place = {"effect": effect, "where": where.partition(" changed")[0]}
    return place | {"share": _short(other.share), "holdout_gain": None, "t": None, "parameters": {}} | _voted(other.votes)


def _short(value: float) -> float:
    return float(f"{value:.6g}")
