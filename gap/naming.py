"""The search, and what outcome and report need of it.

`gap.evidence` finds the most probable set and its neighbours. Here that becomes models on all windows, names with what is like them, and a
verdict with probabilities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

from config.loading.load import LoadedRig
from config.progress import Progress
from gap.all_logs import as_constants, as_fit, half_width, on_all_logs
from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import UNEXPLAINED
from gap.evidence.judgement.words import Alike, Name, Said, asked, said
from gap.evidence.noise.uncut import uncut
from gap.evidence.opening import opening
from gap.evidence.score.changed import Changed
from gap.evidence.score.hypothesis import Hypothesis, Suspect, beyond
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import STAGES
from gap.evidence.visible_sizes import visible_sizes
from gap.fitting.compare import paired_t
from gap.fitting.evaluation import FLOOR, Evaluation, evaluate, mean_cost, recounted
from gap.fitting.fit import Fit
from gap.fitting.model import Model
from gap.fitting.simulate import remembering
from gap.freed_memory import give_back_freed_memory
from gap.outcome.findings import LeastSize
from gap.outcome.localise import Disagreement
from gap.outcome.names import Explanation, Fitted, LookAlike, Named
from gap.outcome.search_state import SearchState
from gap.outcome.unexplained import in_words, where_unexplained
from gap.outcome.verdict import Verdict


@dataclass(frozen=True, slots=True)
class Decided:
    """What the evidence says beside the state it leaves. `half_width`: 95 %, of every free number of the chosen model, by the
    fit logs. `chosen`: that set fitted to all logs; `alone`: constants alone by the fit logs, and fitted to all, where no name is to be
    written."""

    said: Said
    half_width: Array
    chosen: Fitted
    alone: tuple[Model, Fitted] | None
    least: tuple[LeastSize, ...]  # of every suspect beside the chosen set, what the fit logs would have shown
    places: tuple[Disagreement, ...]  # where the chosen set, on all logs, leaves more than honest models leave

    @property
    def written(self) -> Fitted:
        """What the file is written with."""
        return self.alone[1] if self.alone else self.chosen

    @property
    def verdict(self) -> Verdict:
        return Verdict(self.said.word, f"{self.said.why}{in_words(self.places)}", self.said.confirmed)


def decide(
    loaded: LoadedRig, names: Sequence[str], state: SearchState, experiments: Sequence[Experiment], progress: Progress
) -> tuple[SearchState, Decided]:
    """`state`: with the rig file's own constants; `experiments`: the fit logs, whole."""
    search = opening(loaded.rig, state.nominal.free, experiments, names)
    for stage in STAGES:
        search = stage(search, progress)
        give_back_freed_memory()
    search = search.at_its_end(asked(search))
    give_back_freed_memory()
    progress("asking the hold-out")
    outcome = said(search, [uncut(e, loaded.rig, names) for e in state.judging], names)
    state = _with_constants(state, search.null)
    whole = cache(lambda labels: _whole(state, search.fit_of(labels)))  # sets are asked for by several names
    named = tuple(_named(whole, search, outcome.chosen.labels, name) for name in outcome.names)
    blind = half_width(search.seen, outcome.chosen)
    chosen = on_all_logs(state, outcome.all_logs, outcome.on_all[outcome.chosen.labels])
    progress("smallest sizes that would have been named")
    least, places = _least(search, outcome), _places(state, outcome, names, loaded)
    alone = _alone(state, search, outcome)
    (best, seen), (null, null_seen) = whole(outcome.chosen.labels), whole(search.null.labels)
    ended = replace(state, current=best, seen=seen, alone=null, alone_seen=null_seen, named=named)
    return ended, Decided(outcome, blind, chosen, alone, least, places)


def _places(state: SearchState, outcome: Said, names: Sequence[str], loaded: LoadedRig) -> tuple[Disagreement, ...]:
    """Where the chosen set, fitted to all logs, leaves more than honest models leave."""
    chosen = outcome.on_all[outcome.chosen.labels]
    over = beyond(outcome.all_logs, chosen, UNEXPLAINED)
    if not over.any():
        return ()
    done = as_fit(chosen, [*state.experiments, *state.judging], state.costs)
    left = [replace(e, experiment=own) for e, own in zip(done.evaluations, outcome.all_logs.experiments, strict=True)]
    return tuple(where_unexplained(left, chosen.at.discrepancy, over, names, loaded.rig))


def _least(search: EvidenceSearch, outcome: Said) -> tuple[LeastSize, ...]:
    """Sizes at which the others would have been as probable as not, by the fit logs: the hold-out proposes no name."""
    chosen = outcome.chosen
    found = visible_sizes(search.seen, chosen, search.suspects_beside(chosen), -search.log_odds)
    return tuple(
        LeastSize(
            s.suspect.effect, s.suspect.where, s.parameter, s.unit, s.size,
            s.suspect.free.start if isinstance(s.suspect, Changed) else None, s.assumed,
        )
        for s in found
    )  # fmt: skip


def _alone(state: SearchState, search: EvidenceSearch, outcome: Said) -> tuple[Model, Fitted] | None:
    """Constants alone, by the fit logs and by all, where there are names and none is to be written."""
    if outcome.word != "unknown" or not outcome.names:
        return None
    return as_constants(search.null), on_all_logs(state, outcome.all_logs, outcome.on_all[search.null.labels])


Whole = tuple[Fit, tuple[Evaluation, ...]]  # a model on the fit logs and on the hold-out
OfSet = Callable[[frozenset[str]], Whole]  # of a fitted set, by its labels


def _with_constants(state: SearchState, null: Hypothesis) -> SearchState:
    """The state with windows that remember the fitted constants, and costs that count the correlation time of what these leave."""
    vector = as_constants(null).vector()
    few, judging = ([remembering(e, vector) for e in logs] for logs in (state.experiments, state.judging))
    state = replace(state, experiments=few, judging=judging)
    return replace(state, costs=recounted(state.costs, as_fit(null, state.experiments, state.costs).evaluations))


def _whole(state: SearchState, hypothesis: Hypothesis) -> Whole:
    """The model as the fit logs have it, in the costs of the report."""
    done = as_fit(hypothesis, state.experiments, state.costs)
    return done, tuple(evaluate(e, done.model, state.costs) for e in state.holdouts)


def _named(whole: OfSet, search: EvidenceSearch, chosen: frozenset[str], name: Name) -> Named:
    """One name of the chosen set, with its look-alikes."""
    rest = chosen - {name.suspect.label}
    base = whole((search.known(rest) or search.null).labels)
    alike = [_look_alike(whole, other, search.fit_of(rest | {other.label}), base) for other in name.alike]
    return Named(_explanation(name.suspect, whole(chosen), base), name.probability, name.confirmed, name.votes, tuple(alike))


def _look_alike(whole: OfSet, other: Alike, rival: Hypothesis, base: Whole) -> LookAlike:
    suspect = next(s for s in rival.suspects if s.label == other.label)
    return LookAlike(_explanation(suspect, whole(rival.labels), base), other.share, other.votes)


def _explanation(suspect: Suspect, whole: Whole, base: Whole) -> Explanation:
    before, after = mean_cost(base[1]), mean_cost(whole[1])
    return Explanation(suspect, whole[0], whole[1], base[1], (before - after) / max(before - FLOOR, 1e-9), paired_t(base[1], whole[1]))
