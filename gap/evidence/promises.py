"""What every set and one suspect more promises: beside the fitted constants and beside the rig file's own, the best along straight lines.

Where constants have gone far to do what a missing effect does, straight lines from there do not lead to it; where the rig file's own are
far off, those from there lead nowhere. So one suspect alone waits with a promise from both, and so does one more beside a set that leaves
more than honest models leave; else it has one from the fitted constants.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap.evidence.deciding_numbers import NEGLIGIBLE
from gap.evidence.lines import StraightFit, followed
from gap.evidence.refinement import descended, hypothesis_of, with_columns
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import of_other_priors
from gap.evidence.score.hypothesis import Hypothesis, Seen, Suspect, doubtful, honest, hypothesis_at
from gap.evidence.screening import LinearSignature, Promise, Screen, signatures_of, start_of
from gap.evidence.search_state import EvidenceSearch, Open, at_best
from gap.evidence.secants import Secant, secant_where_led, secants_to
from gap.evidence.set_fits import evidence_of
from gap.evidence.side_by_side import side_by_side
from gap.evidence.where_shown import changed_by, first_lines, sizes_shown, taken_there, taken_where_led
from gap.fitting.model import Model
from gap.suspects.candidates import Candidate

_FOLLOWED, _ROUNDS = 8, 2  # best promises of a screening that are followed along straight lines, and lines taken again


def widened(search: EvidenceSearch, base: Hypothesis) -> EvidenceSearch:
    """Every set of `base` and one more that is neither fitted nor waiting, with its promise."""
    suspects = _new_beside(search, base)
    if not suspects:
        return search
    if base.suspects and not doubtful(search.seen, base):
        return _promising(search, base, suspects, base)
    starts = (_as_fitted, _with_own_constants)
    (again, here), (afresh, there) = side_by_side(search.seen, lambda start: start(search, base, suspects), starts)
    waiting = [*here, *there]
    search = replace(search, waiting=(*search.waiting, *waiting), fitted=at_best(at_best(search.fitted, again), afresh))
    for sign in (s for s in search.suspects_beside(base) if not isinstance(s, Changed) and not s.free):
        search = _with_sign(search, base, sign, max((w.gain for w in waiting if w.promise.suspect.label == sign.label), default=-np.inf))
    return search


def _as_fitted(search: EvidenceSearch, base: Hypothesis, suspects: Sequence[Suspect]) -> tuple[Hypothesis, list[Open]]:
    return _promised(search, base, suspects, base)


def _with_own_constants(search: EvidenceSearch, base: Hypothesis, suspects: Sequence[Suspect]) -> tuple[Hypothesis, list[Open]]:
    """The base fitted from the rig file's own constants, and what is promised there."""
    start = at_own_constants(search, base)
    afresh = hypothesis_of(search.seen, base.suspects, descended(search.seen, start.at))
    return _promised(search, start, suspects, afresh)


def _with_sign(search: EvidenceSearch, base: Hypothesis, sign: Candidate, gain: float) -> EvidenceSearch:
    """All sets with a sensor's sign turned and one suspect more, where the turned sign is about as probable: of a sensor that is reversed
    and late neither shows without the other. `gain`: what the sign by itself promises."""
    turned = search.known(base.labels | {sign.label})
    if turned is None and gain > NEGLIGIBLE:
        there = with_columns(search.seen, base.model.with_effect(sign.entry, sign.free), base.at.jacobian, base.at.discrepancy)
        turned = hypothesis_of(search.seen, (*base.suspects, sign), descended(search.seen, there))
        search = replace(search, fitted=(*search.fitted, turned))
    if turned is None or turned.log_z < base.log_z + NEGLIGIBLE:
        return search
    return _promising(search, turned, _new_beside(search, turned), turned)


def beside_start(search: EvidenceSearch, first: Open) -> EvidenceSearch:
    """All sets of a waiting one and one suspect more, with what they promise where its own suspect is tried, not where it ends alone."""
    start, suspects = start_of(first.base.model, first.promise), (*first.base.suspects, first.promise.suspect)
    there = hypothesis_of(search.seen, suspects, with_columns(search.seen, start, first.base.at.jacobian, first.base.at.discrepancy))
    alone = hypothesis_of(search.seen, suspects, descended(search.seen, there.at))
    return _promising(search, there, _new_beside(search, there), alone)


def _new_beside(search: EvidenceSearch, base: Hypothesis) -> list[Suspect]:
    """Suspects with which `base` makes a set that is neither fitted nor waiting."""
    present = {h.labels for h in search.fitted} | {w.labels for w in search.waiting}
    return [s for s in search.suspects_beside(base) if base.labels | {s.label} not in present]


def in_its_place(search: EvidenceSearch, there: Hypothesis, descended_there: Hypothesis) -> EvidenceSearch:
    """Every set of `there` and one more that is neither fitted nor waits there, with its promise where the best set stands, of which
    `there` lacks one suspect: constants are not torn there, and what does the same as that suspect shows by how much. `descended_there`: to
    where that is fitted."""
    known = {h.labels for h in search.fitted} | {w.labels for w in search.waiting if w.base is there}
    suspects = [s for s in search.suspects_beside(there) if there.labels | {s.label} not in known]
    return _promising(search, there, suspects, descended_there)


def _promising(search: EvidenceSearch, start: Hypothesis, suspects: Sequence[Suspect], reached: Hypothesis) -> EvidenceSearch:
    """The search with what every suspect promises beside one start among what waits."""
    reached, waiting = _promised(search, start, suspects, reached)
    return replace(search, waiting=(*search.waiting, *waiting), fitted=at_best(search.fitted, reached))


def _promised(search: EvidenceSearch, start: Hypothesis, suspects: Sequence[Suspect], reached: Hypothesis) -> tuple[Hypothesis, list[Open]]:
    """What every suspect promises beside one start, by what it changes there; the best promises followed along straight lines, which
    promise something without any suspect as well. `reached`: to where one descent from there leads without one; the better one is told."""
    ranked = _ranked(search, start, suspects)
    straight = followed(search.seen, start)
    reached, alone = _led(search, start, straight, reached), (start.log_z, straight.log_z)
    lines = side_by_side(search.seen, lambda p: _along_lines(search, start, p), ranked[:_FOLLOWED])
    return reached, [Open(start, p, line, alone, reached.log_z) for p, line in [*lines, *((p, None) for p in ranked[_FOLLOWED:])]]


def _led(search: EvidenceSearch, start: Hypothesis, straight: StraightFit, reached: Hypothesis) -> Hypothesis:
    """To where a descent leads without any suspect from where lines do, if those promise more than one from the start has reached: a fit
    with a suspect begins there too, and must not be credited with that."""
    if straight.log_z <= reached.log_z:
        return reached
    point = with_columns(search.seen, straight.model, start.at.jacobian, straight.discrepancy)
    return max(reached, hypothesis_of(search.seen, start.suspects, descended(search.seen, point)), key=evidence_of)


def _ranked(search: EvidenceSearch, start: Hypothesis, suspects: Sequence[Suspect]) -> list[Promise]:
    """A promise of every suspect, that comes first which would be the best if what an honest model leaves were all that is left beside it:
    the discrepancy of a start without it has grown by what it explains, and hides it."""
    seen, right = search.seen, honest(search.seen, start)
    signatures = signatures_of(seen, start, [s for s in suspects if isinstance(s, Candidate)])
    one_each = first_lines(signatures)
    screens = [Screen(seen, base, signatures) for base in (right, start)]
    small = taken_there(seen, start, one_each, sizes_shown(screens[0], one_each, -search.log_odds))
    changed = [s for s in suspects if isinstance(s, Changed)]
    far = {s.label: s.free.start + changed_by(screens[0], start.model, s, -search.log_odds) for s in changed}
    secants = secants_to(seen, start, far, changed)
    again = [Screen(seen, base, small, secants) for base in (right, start)]
    hopes, promises = (
        _best_each(
            [*map(first.missing, signatures), *map(second.missing, small)]
            + [*map(first.changed, changed), *(second.changed(s.suspect, s) for s in secants)]
        )
        for first, second in zip(screens, again, strict=True)
    )
    return sorted(promises.values(), key=lambda promise: -hopes[promise.suspect.label].log_z)


def _best_each(promises: Sequence[Promise]) -> dict[str, Promise]:
    """By label of the suspect."""
    return {promise.suspect.label: promise for promise in sorted(promises, key=lambda p: p.log_z)}


def at_own_constants(search: EvidenceSearch, base: Hypothesis) -> Hypothesis:
    """The set with the rig file's own constants, the suspects as fitted: where a missing effect has torn constants away, straight lines
    from there lead nowhere."""
    if not base.suspects:
        return search.nominal
    point = with_columns(search.seen, base.model.with_own_constants(), _own_columns(search, base), base.at.discrepancy)
    return hypothesis_at(search.seen, base.suspects, point)


def _along_lines(search: EvidenceSearch, start: Hypothesis, promise: Promise) -> tuple[Promise, StraightFit | None]:
    """A promise followed along straight lines; again with lines to where they have led, as an effect is seldom proportional to its size."""
    if isinstance(promise.signature, LinearSignature) and not promise.has_size:
        return promise, None
    fit = followed(search.seen, start, promise)
    for _ in range(_ROUNDS):
        nearer = _nearer(search.seen, start, promise, fit.model)
        if nearer is None:
            break
        again = replace(promise, signature=nearer)
        found = followed(search.seen, start, again)
        if found.log_z <= fit.log_z:
            break
        promise, fit = again, found
    return promise, fit


def _nearer(seen: Seen, start: Hypothesis, promise: Promise, there: Model) -> LinearSignature | Secant | None:
    """The promise's lines taken again to where they have led."""
    if isinstance(promise.signature, LinearSignature):
        return taken_where_led(seen, start, promise.signature, there)
    assert isinstance(promise.suspect, Changed)
    return secant_where_led(seen, start, promise.suspect, promise.signature, there)


def _own_columns(search: EvidenceSearch, base: Hypothesis) -> Sequence[np.ndarray]:
    """Sensitivities about the rig file's own constants, with those of the set's effects as they are."""
    own, constants = search.nominal, len(search.nominal.model.free)
    columns = [of_other_priors(j, own.model, base.model) for j in own.at.jacobian]
    return [np.concatenate([c, j[constants:]]) for c, j in zip(columns, base.at.jacobian, strict=True)]
