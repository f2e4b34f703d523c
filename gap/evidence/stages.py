"""The search, as a list of stages; each takes what is known and returns what is known then.

1. `refitted`: the constants alone, fitted to their end.
2. `grown`: the best set and one suspect more, best promise first, until none that waits could still overtake; then from the new best set.
3. `exchanged`: the best set less one, and with another in its place: the same question asked of its neighbours.
4. `settled`: whatever still has a share of the posterior is fitted with sensitivities of its own, since shares are compared.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gap.evidence.ahead import fitted
from gap.evidence.deciding_numbers import NEGLIGIBLE
from gap.evidence.promises import at_own_constants, beside_start, in_its_place, widened
from gap.evidence.refinement import FEW_PASSES, by_magnitude, descended, finished, hypothesis_of
from gap.evidence.score.hypothesis import Hypothesis, Seen, about_fit, beyond, doubtful, reweighed
from gap.evidence.search_state import EvidenceSearch, Open, Start, at_best
from gap.evidence.set_fits import evidence_of, from_magnitudes, less, part_of, refined, taken_on, to_floor
from gap.evidence.side_by_side import side_by_side

Progress = Callable[[str], None]
Stage = Callable[[EvidenceSearch, Progress], EvidenceSearch]

_ROUNDS, _WORTH = 2, 2.0  # of the constants alone, beside what is integrated out about them, and the ln Z for which there is another
_MOST_EFFECTS = 3  # in one set: more than three at once have a probability of 2 % beforehand
_FIRST_ONES = 2  # suspects beside a best set that leaves too much, with which a second one is looked for at once
_PATIENCE = 6  # fits in a row, best promise first, after which no better set is expected of what else is promised from the same start
_ALWAYS = 4  # sets that are fitted however little they promise while the best leaves too much: no lines lead along a delay or a dead band


def refitted(search: EvidenceSearch, progress: Progress) -> EvidenceSearch:
    """The constants alone, from the rig file's own. While more is left than honest models leave, their floor does not matter yet."""
    at, seen = search.nominal, search.seen
    done = finished(seen, (), by_magnitude(seen, descended(seen, at.at)), FEW_PASSES)
    for _ in range(_ROUNDS):
        if np.any(beyond(seen, done)):
            break
        seen = about_fit(seen, done)
        before = reweighed(seen, done)
        done = finished(seen, (), by_magnitude(seen, before.at))
        if done.log_z < before.log_z + _WORTH:
            break
    nominal = reweighed(seen, at)  # beside what is integrated out now, as `done` is
    progress(f"constants alone: log evidence {done.log_z:.1f} ({done.log_z - nominal.log_z:+.1f} beside the rig file's own)")
    return replace(search, seen=seen, nominal=nominal, fitted=(done,))


def grown(search: EvidenceSearch, progress: Progress) -> EvidenceSearch:
    """One suspect more, as long as the posterior grows with it."""
    while len(search.best.suspects) < _MOST_EFFECTS:
        best = search.best
        progress(_screening(search, best))
        wide = widened(search, best)
        search = _decided(wide, best, progress, 0 if best.suspects else _ALWAYS)
        search = _two_at_once(search, best, wide.waiting, progress)
        if search.best.labels == best.labels:
            break
        search = _about_best(search, best)
    return search


def _screening(search: EvidenceSearch, base: Hypothesis) -> str:
    return f"screening {len(search.suspects_beside(base))} suspects beside {_words(base)}"


def _beside_promise(search: EvidenceSearch, waiting: Open, done: Hypothesis) -> str:
    gained = done.log_z - search.fit_of(waiting.base.labels).log_z
    return f"  {_words(done)}: {gained:+.1f} (promised {waiting.gain:+.1f})"


def _words(hypothesis: Hypothesis) -> str:
    return ", ".join(sorted(hypothesis.labels)) or "constants alone"


def _two_at_once(search: EvidenceSearch, best: Hypothesis, promised: Sequence[Open], progress: Progress) -> EvidenceSearch:
    """Neither of two effects may show without the other, as a link that bends and a late sensor at its tip: alone the first one ends where
    it does nothing. So where a set stays the best and leaves more than honest models leave, or its constants have gone far to leave less, a
    second suspect is looked for where the most promising first ones are tried."""
    now = search.best
    if now.labels != best.labels or len(now.suspects) + 2 > _MOST_EFFECTS or not doubtful(search.seen, now):
        return search
    firsts: dict[frozenset[str], Open] = {}
    for waiting in sorted(promised, key=lambda w: -w.gain):
        if waiting.base.labels == best.labels and waiting.promise.has_size:
            firsts.setdefault(waiting.labels, waiting)
    for first in list(firsts.values())[:_FIRST_ONES]:
        search = beside_start(search, first)
    return _decided(search, best, progress, 0)


def exchanged(search: EvidenceSearch, progress: Progress) -> EvidenceSearch:
    """The neighbours of the likeliest set that has names: one less, and another in its place. A better one is asked again."""
    while lead := _leading(search):
        for suspect in lead.suspects:
            part = part_of(search, lead, suspect)
            search = less(search, lead, part)
            rest = search.fit_of(part[0].labels)
            progress(_screening(search, rest))
            search = in_its_place(widened(search, rest), *part)
            search = _rivals_ended(_decided(search, lead, progress, 0), lead, rest)
        after = _leading(search)
        if after is None or after.labels == lead.labels:
            break
        if search.best is after:
            search = grown(_about_best(search, lead), progress)
    return search


def _leading(search: EvidenceSearch) -> Hypothesis | None:
    """The best set, or, where that has no names, the best that has and holds a share: the hold-out may speak for it."""
    shares = search.shares
    named = [(share, h) for share, h in zip(shares, search.fitted, strict=True) if h.suspects]
    share, lead = max(named, key=lambda one: one[0], default=(0.0, None))
    return lead if share > max(shares) * np.exp(NEGLIGIBLE) else None


def _rivals_ended(search: EvidenceSearch, best: Hypothesis, rest: Hypothesis) -> EvidenceSearch:
    """The best set's rivals fitted as far: a delay, to which no lines lead, beside another one."""
    for rival in _rivals(search, best, rest):
        search = search if rival.ended else taken_on(search, rival)
    return search


def _rivals(search: EvidenceSearch, best: Hypothesis, rest: Hypothesis) -> list[Hypothesis]:
    """Sets of as many suspects that gain half of what the best one has over the rest: they may be as good when they are fitted as far."""
    half = 0.5 * (search.fit_of(best.labels).log_z + search.fit_of(rest.labels).log_z)
    beside = [h for h in search.fitted if rest.labels < h.labels and len(h.labels) == len(best.labels) and h.labels != best.labels]
    return [h for h in beside if h.log_z > half]


def _followed(seen: Seen, hypothesis: Hypothesis) -> Hypothesis:
    """A set beside what is integrated out now, its numbers fitted to that too."""
    there = reweighed(seen, hypothesis)
    return finished(seen, there.suspects, there.at, FEW_PASSES)


def settled(search: EvidenceSearch, progress: Progress) -> EvidenceSearch:
    """Every set that holds a share of the posterior fitted with sensitivities of its own, and what it has beyond any of its suspects from
    there as well; and what waits where its promise would be said."""
    while True:
        shares = search.shares
        least = max(shares) * np.exp(NEGLIGIBLE)
        unsure = [(share, h) for share, h in zip(shares, search.fitted, strict=True) if not h.ended and share > least]
        if not unsure:
            awaited = _awaited(search)
            if awaited is None:
                return search
            search = _without_promise(search, awaited, progress)
            continue
        best = max(unsure, key=lambda one: one[0])[1]
        progress(f"to its end: {_words(best)}")
        search = to_floor(search, best)
        done = search.fit_of(best.labels)
        for suspect in done.suspects:
            search = less(search, done, part_of(search, done, suspect))


def _awaited(search: EvidenceSearch) -> Open | None:
    """A set that only waits, where what it promises would be said of one of the best set's names."""
    posterior, fitted, best = search.posterior, {h.labels for h in search.fitted}, search.best.labels
    for label in sorted(best):
        alike = {best - {label} | {other} for other, _ in posterior.in_place_of(best, label)}
        said = posterior.between(label, fitted) or alike - fitted
        if said:
            return max((w for w in search.waiting if w.labels in said), key=search.log_hope)
    return None


def _without_promise(search: EvidenceSearch, waiting: Open, progress: Progress) -> EvidenceSearch:
    """The set fitted, and what it promised forgotten."""
    done = refined(search, waiting)
    progress(_beside_promise(search, waiting, done))
    rest = tuple(w for w in search.waiting if w.labels != waiting.labels)
    return replace(search, waiting=rest, fitted=at_best(search.fitted, done))


def _about_best(search: EvidenceSearch, before: Hypothesis) -> EvidenceSearch:
    """The new best set fitted to its end, lest constants on their way sell what is left of it to whatever is added next. Where `before`
    left more than honest models do, constants were torn away: then all sets are weighed anew beside what is integrated out about the
    new best one. If a rival, fitted as far there, is the best beside that, it is fitted on from there here as well, and takes its place if
    it is the best here too; else all stay as they were (a link that bends gives every window a start to vibrate from, also to a set whose
    link is rigid)."""
    best = search.best
    if not np.any(beyond(search.seen, before)):
        return from_magnitudes(search, best)
    anew = _beside_its_unknowns(search, best, before)
    if anew.best.labels == best.labels:
        return anew
    rival = hypothesis_of(search.seen, anew.best.suspects, descended(search.seen, reweighed(search.seen, anew.best).at))
    search = replace(search, fitted=at_best(search.fitted, rival))
    return from_magnitudes(search, best) if search.best.labels == best.labels else _about_best(search, before)


def _beside_its_unknowns(search: EvidenceSearch, best: Hypothesis, before: Hypothesis) -> EvidenceSearch:
    """All sets beside what is integrated out about the best one, the same for all; that one fitted from the rig file's own constants too,
    and its rivals as far."""
    seen, rivals = about_fit(search.seen, best), {r.labels for r in _rivals(search, best, search.fit_of(before.labels))}
    nominal, *others = side_by_side(
        seen, lambda h: _followed(seen, h) if h.labels in rivals else reweighed(seen, h), (search.nominal, *search.fitted)
    )
    anew = replace(search, seen=seen, nominal=nominal, fitted=tuple(others))
    there = anew.fit_of(best.labels)
    afresh = hypothesis_of(seen, best.suspects, descended(seen, at_own_constants(anew, there).at))
    return from_magnitudes(anew, max(there, afresh, key=evidence_of))


STAGES: tuple[Stage, ...] = (refitted, grown, exchanged, settled)


def _decided(search: EvidenceSearch, base: Hypothesis, progress: Progress, always: int) -> EvidenceSearch:
    """The waiting sets fitted, best promise first, until none that is left could hold a share of the posterior; `always` of those at least
    that seem to hold none, once one set is better than the base, unless that one leaves what honest models leave. Promises from one start
    after the other are given up: where lines do not hold, all of them are."""
    hopeless: set[frozenset[str]] = set()
    in_vain: Counter[Start] = Counter()  # fits in a row
    ahead = None
    while believed := [w for w in search.waiting if in_vain[w.start] < _PATIENCE]:
        first, before = _most_hoped_for(believed, search), search.best.labels
        if not _hopeful(search, first):
            hopeless |= {first.labels}
            if len(hopeless) > always or (not base.suspects and before == base.labels) or not doubtful(search.seen, search.best):
                break
        others = [w for w in believed if w is not first]
        after = _most_hoped_for(others, search) if others and (in_vain.total() or first.labels in hopeless) else None
        done, ahead = fitted(search, first, after, ahead)
        progress(_beside_promise(search, first, done))
        search = search.reached(first, done)
        if search.best.labels == done.labels:
            search = less(search, done, part_of(search, done, first.promise.suspect))
        in_vain[first.start] = 0 if search.best.labels != before else in_vain[first.start] + 1
    top = search.log_mass(search.best)  # what is promised beyond that and not believed holds no share
    kept = tuple(w for w in search.waiting if in_vain[w.start] < _PATIENCE or search.log_hope(w) <= top)
    return replace(search, waiting=kept)


def _most_hoped_for(waiting: Sequence[Open], search: EvidenceSearch) -> Open:
    return max(waiting, key=search.log_hope)


def _hopeful(search: EvidenceSearch, waiting: Open) -> bool:
    """Whether it could hold a share of the posterior."""
    return search.log_hope(waiting) >= search.log_mass(search.best) + NEGLIGIBLE
