"""One set of the search fitted: from what it was promised, towards its end, and without one of its suspects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gap.evidence.deciding_numbers import NEGLIGIBLE
from gap.evidence.lines import joined
from gap.evidence.refinement import FEW_PASSES, by_magnitude, descended, finished, hypothesis_of, with_columns
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import of_other_priors
from gap.evidence.score.hypothesis import Hypothesis, Point, Suspect, beyond
from gap.evidence.screening import Promise, start_of
from gap.evidence.search_state import EvidenceSearch, Open, at_best
from gap.evidence.sensitivity import renewed
from gap.fitting.fit import HALF
from gap.fitting.model import Model

Part = tuple[Hypothesis, Hypothesis]  # a set without one of its suspects: where it stands, and fitted from there


def refined(search: EvidenceSearch, chosen: Open) -> Hypothesis:
    """The set fitted from where straight lines lead; further, if that is as much above what the base gets to from there as it would have
    to be above the base. Where the base leaves more than honest models leave, its sensitivities are torn away as its constants are: what
    falls short of half of its promise then, or becomes the best set, is fitted with fresh ones as well."""
    start, base = _start(search, chosen), search.fit_of(chosen.base.labels)

    def fitted(point: Point) -> Hypothesis:
        return hypothesis_of(search.seen, (*chosen.base.suspects, chosen.promise.suspect), descended(search.seen, point))

    done = fitted(start)
    short = done.log_z < chosen.level + HALF * chosen.gain
    if done.log_z < base.log_z and chosen.promise.suspect.free:  # lines led astray: from where the base ends, step by step
        done = max(done, fitted(_beside(search, base, chosen.promise)), key=evidence_of)
    enough = search.log_mass(search.best)
    if np.any(beyond(search.seen, base)) and (short or search.log_mass(done) > enough):
        done = max(done, fitted(renewed(search.seen, start)), key=evidence_of)
    hope = search.log_mass_with(chosen, done.log_z - chosen.level)
    if search.log_mass(done) > enough or hope < enough + NEGLIGIBLE:
        return done
    return finished(search.seen, done.suspects, done.at, FEW_PASSES)


def _start(search: EvidenceSearch, chosen: Open) -> Point:
    """Where straight lines lead, with sensitivities taken anew where those of the base do not tell enough."""
    base, lines = chosen.base, chosen.lines
    model = lines.model if lines else start_of(base.model, chosen.promise)
    known = joined(base, chosen.promise)[1] if isinstance(chosen.promise.suspect, Changed) else base.at.jacobian
    point = with_columns(search.seen, model, known, lines.discrepancy if lines else base.at.discrepancy)
    return renewed(search.seen, point) if chosen.lines_end_early else point


def _beside(search: EvidenceSearch, base: Hypothesis, promise: Promise) -> Point:
    """The base with one suspect more, of a size that changes nothing yet."""
    model, jacobian = joined(base, promise)
    return replace(base.at, model=model, readings=search.seen.readings(model), jacobian=jacobian)


def less(search: EvidenceSearch, best: Hypothesis, part: Part) -> EvidenceSearch:
    """The best set without one of its suspects, fitted on from where that has led the constants: a fit that has stopped short of its
    valley's floor must not sell the rest to whatever is added next."""
    search = replace(search, fitted=at_best(search.fitted, max(part, key=evidence_of)))
    rest = search.fit_of(part[0].labels)
    close = search.log_mass(rest) > search.log_mass(best) + NEGLIGIBLE
    return taken_on(search, rest) if close and not rest.ended else search


def part_of(search: EvidenceSearch, start: Hypothesis, gone: Suspect) -> Part:
    """A fitted set without one of its suspects: where it stands, and fitted from there."""
    suspects = tuple(s for s in start.suspects if s is not gone)
    model, jacobian = _without(search, suspects, start)
    there = with_columns(search.seen, model, jacobian, start.at.discrepancy)
    return hypothesis_of(search.seen, suspects, there), hypothesis_of(search.seen, suspects, descended(search.seen, there))


def _without(search: EvidenceSearch, suspects: tuple[Suspect, ...], start: Hypothesis) -> tuple[Model, list[np.ndarray]]:
    model, keep = start.model, set(range(len(start.model.free)))
    for gone in (s for s in start.suspects if s.label not in {k.label for k in suspects}):
        if isinstance(gone, Changed):
            model = gone.with_own_prior(model, search.nominal.model)
        else:
            entry = model.entry_added(gone.effect, gone.where)
            keep -= set(start.model.of_effect(entry))
            model = model.without_effect(entry)
    return model, [of_other_priors(j, start.model, model)[sorted(keep)] for j in start.at.jacobian]


def to_floor(search: EvidenceSearch, hypothesis: Hypothesis) -> EvidenceSearch:
    """One set taken to its floor, also where more is left than honest models leave: on its way it sells that to a wrong name."""
    return _with(search, finished(search.seen, hypothesis.suspects, hypothesis.at))


def from_magnitudes(search: EvidenceSearch, hypothesis: Hypothesis) -> EvidenceSearch:
    """The same from the best of several magnitudes: a set that brings friction brings contacts of which only the magnitude is known."""
    return to_floor(search, replace(hypothesis, at=by_magnitude(search.seen, hypothesis.at)))


def taken_on(search: EvidenceSearch, hypothesis: Hypothesis) -> EvidenceSearch:
    """One set taken towards it."""
    return _with(search, finished(search.seen, hypothesis.suspects, hypothesis.at, FEW_PASSES))


def _with(search: EvidenceSearch, fitted: Hypothesis) -> EvidenceSearch:
    return replace(search, fitted=(*(h for h in search.fitted if h.labels != fitted.labels), fitted))


def evidence_of(hypothesis: Hypothesis) -> float:
    return hypothesis.log_z
