"""From the course of a search to one honest sentence: no gap, wrong constants, named effects, look-alikes, or unknown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.data.coarse_steps import CoarseStep
from gap.data.measured import Array
from gap.fitting.evaluation import NO_GAP, Costing, Evaluation, mean_cost
from gap.fitting.fit import Fit, covariance
from gap.search.look_alikes import look_alikes
from gap.search.search_state import GateSearch
from gap.search.trial import FLOOR

EXPLAINED = 1.10  # noise floors up to which constants alone are believed to explain a gap; up to CLOSED where they explain 98 % of it
CLOSED = 1.5  # names are confirmed only when the hold-out ends below this
CLEAR = 0.5  # share of what the constants had left that may remain for that: more is within what a model error of another kind can feign
REMAINDER = 0.10  # share of the first excess that may remain for names to stand, though not confirmed
ALARM = 3.0  # prior standard deviations: the constant, its prior or the structure is wrong
BOOTSTRAPS = 200
_BLOCK = 3  # neighbouring windows drawn together


@dataclass(frozen=True, slots=True)
class Verdict:
    """The word of the findings file and why, in a sentence. `confirmed`: the gap is closed by what is named; a name may still be weak."""

    word: str
    why: str
    confirmed: bool


def verdict(state: GateSearch, before: float, refit: float, after: float, unsteady: str = "") -> Verdict:
    """`before`, `refit`, `after`: hold-out costs of the rig file, of its refitted constants and of the final model, in noise floors.
    `unsteady`: changed constants that are not the same in every log, in words."""
    if state.steps:
        return _named(state, before, refit, after)
    other = "other effect" if state.coarse else "effect"
    alarms = alarmed(state.current)
    left = still_open(state.nominal.evaluations)
    if before <= NO_GAP and left:
        why = (
            f"The rig file predicts the hold-out within {before:.2f} noise floors, but {left}: hold out a log that moves as that one does."
        )
        return Verdict("unknown", why, False)
    if before <= NO_GAP:
        return Verdict("no_gap", f"The rig file predicts the hold-out within {before:.2f} noise floors.", True)
    if refit <= EXPLAINED or (refit <= CLOSED and refit - FLOOR <= 0.02 * (before - FLOOR)):
        far = f" Beyond {ALARM:g} prior standard deviations: {', '.join(alarms)}." if alarms else ""
        moved = f"Other values of the rig's constants alone bring the hold-out from {before:.3g} to {refit:.3g} noise floors"
        left = still_open(state.current.evaluations)
        rest = f", but {left}: the hold-out shows less of the gap." if left else "." if unsteady else f"; no {other} shows in these logs."
        hides = f" But {unsteady}: a missing effect may hide there." if unsteady else ""
        return Verdict("parameter_mismatch", f"{moved}{rest}{hides}{far}", not (alarms or left or unsteady))
    why = f"The hold-out stays at {refit:.3g} noise floors with the best constants, and no known {other} passes the gates."
    return Verdict("unknown", why, False)


def with_steps(word: Verdict, coarse: Sequence[CoarseStep]) -> Verdict:
    """The verdict of the search beside readings whose steps the data show by themselves: these are named however the rest ends."""
    if not coarse or word.word == "data_problem":
        return word
    said = "; ".join(item.text() for item in coarse)
    plain = word.word in ("no_gap", "parameter_mismatch")
    return Verdict("named" if plain else word.word, f"{said}. {word.why}", word.confirmed)


def _named(state: GateSearch, before: float, refit: float, after: float) -> Verdict:
    names = " and ".join(f"{s.trial.candidate.effect} at {s.trial.candidate.where}" for s in state.steps)
    rest = (after - FLOOR) / max(before - FLOOR, 1e-9)
    gap = f"the hold-out goes from {before:.4g} to {after:.4g} noise floors"
    if after > CLOSED and rest > REMAINDER:
        why = f"{names} help, but {rest:.0%} of the gap remains ({gap}): an effect outside the library or a constant that is not free."
        return Verdict("unknown", why, False)
    closed, doubts = _closed(state, refit, after, rest)
    unclear = [(s.trial, *alike) for s in state.steps if (alike := look_alikes(state, s))]
    if unclear:
        sets = "; ".join("{" + ", ".join(f"{t.candidate.effect} at {t.candidate.where}" for t in trials) + "}" for trials in unclear)
        return Verdict("ambiguous", f"These logs cannot tell apart {sets}; with the simplest, {gap}.{doubts}", False)
    return Verdict("named", f"With {names}, {gap}.{doubts}", closed)


def _closed(state: GateSearch, refit: float, after: float, rest: float) -> tuple[bool, str]:
    """Whether the names close the gap, and what makes them tentative, in a sentence. `rest`: share of the gap that remains."""
    clear = after - FLOOR <= CLEAR * max(refit - FLOOR, NO_GAP - FLOOR)
    if state.strained:
        far = f"{', '.join(state.strained)} more than {ALARM:g} prior standard deviations away"
        return False, f" Constants alone would do as much with {far}, so the names are tentative: check these constants."
    if after > CLOSED:
        return False, f" {rest:.1%} of the gap remains, so the names are tentative."
    if not clear:
        return False, f" The best constants alone end at {refit:.3g}, so the names are tentative."
    left = still_open(state.current.evaluations)
    if left:
        return False, f" But {left}, which the hold-out does not show, so the names are tentative."
    weak = "; ".join(f"{s.trial.candidate.effect} at {s.trial.candidate.where} {s.weak}" for s in state.steps if s.weak)
    return True, f" But {weak}: tentative." if weak else ""


def still_open(now: Sequence[Evaluation]) -> str:
    """The fitted log that a model predicts worst, in words, when that is no prediction; a hold-out that moves less may hide it."""
    worst = max(now, key=lambda e: mean_cost([e]))
    cost = mean_cost([worst])
    return f"{worst.experiment.log.path.name} only within {cost:.3g}" if cost > CLOSED else ""


def alarmed(done: Fit) -> list[str]:
    """Constants that left their prior."""
    return [free.key for free, pull in zip(done.model.free, done.model.pulls, strict=True) if abs(pull) >= ALARM]


def confidence(done: Fit, costs: Costing, seed: int = 0) -> Array:
    """95 % half width of every free number: the larger of posterior and block bootstrap over windows (linearised)."""
    posterior = np.sqrt(np.maximum(np.diag(covariance(done, costs)), 0.0))
    return np.asarray(1.96 * np.maximum(posterior, bootstrap_sd(done, costs, seed)))


def bootstrap_sd(done: Fit, costs: Costing, seed: int = 0) -> Array:
    """Spread of the fitted numbers when windows are drawn again with repetition."""
    temper = max(1.0, done.cost) * costs.tau
    scores = np.concatenate([_window_scores(e, j) for e, j in zip(done.evaluations, done.columns, strict=True)], axis=1) / temper
    inverse = covariance(done, costs) / np.outer(done.model.scales, done.model.scales)
    blocks = [scores[:, k : k + _BLOCK].sum(axis=1) for k in range(0, scores.shape[1], _BLOCK)]
    stacked, draw = np.stack(blocks, axis=1), np.random.default_rng(seed)
    picks = draw.integers(0, len(blocks), (BOOTSTRAPS, len(blocks)))
    moves = np.stack([inverse @ stacked[:, pick].sum(axis=1) for pick in picks])
    return np.asarray(moves.std(axis=0) * done.model.scales)


def _window_scores(evaluation: Evaluation, columns: Array) -> Array:
    """Gradient of the fit by window: numbers × windows."""
    return np.asarray(np.einsum("kwn,wn->kw", columns, evaluation.left))


def channel_rms(evaluations: tuple[Evaluation, ...], names: list[str]) -> dict[str, float]:
    """Root mean square of what is left in each channel, in its unit."""
    found = {}
    for k, name in enumerate(names):
        parts = []
        for e in evaluations:
            left = e.left[:, : e.experiment.measured[0].size].reshape(e.experiment.measured.shape)[:, :, k]
            parts.append(left[np.isfinite(e.experiment.measured[:, :, k])] * e.experiment.sigma[k])
        pooled = np.concatenate(parts)
        found[name] = float(np.sqrt(np.mean(pooled**2))) if pooled.size else float("nan")
    return found
