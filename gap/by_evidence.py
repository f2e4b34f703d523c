"""The search by evidence in the place of the search by gates: the same state for outcome and report, and what is said of it.

`gap.evidence` finds the most probable set and its neighbours. Here that becomes models on all windows, trials beside the best one, and a
verdict with probabilities. A number of the rig file that has changed is no effect to be added: it is written as a constant, and its finding
says what was `stated` and the `value` now.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from config.loading.load import LoadedRig
from config.progress import Progress
from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import RANGE_SDS
from gap.evidence.noise.uncut import uncut
from gap.evidence.opening import opening
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import stretch
from gap.evidence.score.hypothesis import Hypothesis, posterior
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import STAGES
from gap.evidence.words import Name, Said, said
from gap.fitting.compare import paired_t
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.fit import Fit, fit
from gap.fitting.model import Free, Model
from gap.outcome.findings import number
from gap.search.search_state import GateSearch, Step
from gap.search.trial import FLOOR, Trial
from gap.search.verdict import Verdict
from gap.signatures.candidates import Candidate


@dataclass(frozen=True, slots=True)
class Decided:
    """What the evidence says beside the state that it was put into. `half_width`: 95 %, of every free number of the chosen model."""

    said: Said
    half_width: Array
    changes: tuple[dict[str, Any], ...]  # findings: numbers of the rig file that have changed

    @property
    def verdict(self) -> Verdict:
        return Verdict(self.said.word, self.said.why, self.said.confirmed)

    def with_probability(self, item: dict[str, Any]) -> dict[str, Any]:
        """A finding with its probability, and its look-alikes with their shares."""
        name = next((n for n in self.said.names if n.suspect.label == f"{item['effect']} at {item['where']}"), None)
        if name is None:
            return item
        fitted = {f"{rival['effect']} at {rival['where']}": rival for rival in item["look_alikes"]}
        alike = [_rival(label, share) | fitted.get(label, {}) for label, share in name.alike]
        return item | {"probability": _short(name.probability), "confirmed": name.confirmed, "look_alikes": alike}


def by_evidence(
    loaded: LoadedRig, names: Sequence[str], state: GateSearch, experiments: Sequence[Experiment], progress: Progress
) -> tuple[GateSearch, Decided]:
    """`state`: with its constants refitted; `experiments`: the fit logs, whole."""
    search = opening(loaded.rig, state.nominal.model.free, experiments, names)
    for stage in STAGES:
        search = stage(search, progress)
    outcome = said(search, [uncut(e, loaded.rig, names) for e in state.holdouts], names)
    best, null = _on_all(state, outcome.chosen), _on_all(state, search.null)
    without = {n.suspect.label: search.known(outcome.chosen.labels - {n.suspect.label}) or search.null for n in outcome.names}
    bases = [(n, _on_all(state, without[n.suspect.label])) for n in outcome.names]
    steps = [_step(state, search, outcome.chosen, n, best, base) for n, base in bases if isinstance(n.suspect, Candidate)]
    half_width = _half_width(search, outcome.chosen)
    changes = tuple(_changed(outcome.chosen, half_width, n, best, base) for n, base in bases if isinstance(n.suspect, Changed))
    state = replace(state, current=best[0], seen=best[1], constants_only=null[1], steps=tuple(steps))
    return state, Decided(outcome, half_width, changes)


Whole = tuple[Fit, tuple[Evaluation, ...]]  # a model on the fit logs and on the hold-out


def _on_all(state: GateSearch, hypothesis: Hypothesis) -> Whole:
    """The model as it was fitted, in the costs of the report."""
    model = _as_constants(hypothesis)
    rescaled = (model.scales / hypothesis.model.scales / stretch(hypothesis.model))[:, None, None, None]
    jacobian = [rescaled * j * e.sigma for j, e in zip(hypothesis.at.jacobian, state.experiments, strict=True)]
    done = fit(model, state.experiments, state.costs, (), jacobian, 0)
    return done, tuple(evaluate(e, model, state.costs) for e in state.holdouts)


def _half_width(search: EvidenceSearch, chosen: Hypothesis) -> Array:
    """95 % of the posterior, of every free number in its unit."""
    sd = np.sqrt(np.diag(np.linalg.inv(posterior(replace(search.seen, counts=1.0), chosen.at).precision)))
    return np.asarray(1.96 * sd * chosen.model.scales * stretch(chosen.model))


def _as_constants(hypothesis: Hypothesis) -> Model:
    """Numbers that have changed as constants of wide priors, which the file is written with."""
    changed = {s.free.key for s in hypothesis.suspects if isinstance(s, Changed)}
    return replace(hypothesis.model, free=tuple(_wide(f) if f.key in changed else f for f in hypothesis.model.free))


def _wide(free: Free) -> Free:
    return replace(free, prior=True, scale=max(free.high - free.start, free.start - free.low) / RANGE_SDS)


def _step(state: GateSearch, search: EvidenceSearch, chosen: Hypothesis, name: Name, best: Whole, base: Whole) -> Step:
    """One name as an accepted effect, its look-alikes as its rivals."""
    assert isinstance(name.suspect, Candidate)
    own = name.suspect
    rest, rivals = chosen.labels - {own.label}, []
    for label, _ in name.alike:
        rival = search.known(rest | {label})
        suspect = next((s for s in rival.suspects if s.label == label), None) if rival else None
        if rival and isinstance(suspect, Candidate):
            rivals.append(_trial(suspect, _on_all(state, rival), base))
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


def _changed(chosen: Hypothesis, half_width: Array, name: Name, best: Whole, base: Whole) -> dict[str, Any]:
    """The finding of a number that has changed."""
    assert isinstance(name.suspect, Changed)
    free, model = name.suspect.free, chosen.model
    at = next(k for k, f in enumerate(model.free) if f.key == free.key)
    value, effect = float(model.theta[at]), EFFECTS.get(name.suspect.effect)
    return {
        "effect": name.suspect.effect,
        "where": name.suspect.where,
        "confirmed": name.confirmed,
        "probability": _short(name.probability),
        "stated": _short(free.start),
        "value": _short(value),
        "parameters": {free.key.rpartition(".")[2]: number(value, float(half_width[at]), free.unit)},
        "holdout_gain": _short(_gain(best, base)),
        "t": _short(paired_t(base[1], best[1])),
        "look_alikes": [_rival(label, share) for label, share in name.alike],
        "fingerprint": effect.fingerprint if effect else "",
        "equation": effect.search.equation if effect and effect.search else "",
    }


def _rival(label: str, share: float) -> dict[str, Any]:
    effect, _, where = label.partition(" at ")
    place = {"effect": effect, "where": where.partition(" changed")[0]}
    return place | {"share": _short(share), "holdout_gain": None, "t": None, "parameters": {}}


def _short(value: float) -> float:
    return float(f"{value:.6g}")
