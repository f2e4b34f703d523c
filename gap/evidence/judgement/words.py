"""From shares of the posterior and the judge to what is said: names with their probabilities, or why there are none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from config.readable import probability
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import CONFIRMED, NEGLIGIBLE, UNEXPLAINED
from gap.evidence.judgement.judge import ended_on_all_logs, led_by, of_rig_file, on_all_logs, together
from gap.evidence.judgement.nested import nested
from gap.evidence.judgement.posterior import of_all_logs
from gap.evidence.judgement.preference import Preference, preferences
from gap.evidence.judgement.votes import Ballot, Votes
from gap.evidence.score.hypothesis import MOST_HONEST, Hypothesis, Seen, Suspect, about, beyond
from gap.evidence.score.shares import Shares
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.side_by_side import side_by_side

_ONLY_HELD_OUT = "The fit logs leave no more than that: fit the hold-out too, and hold out another log."


@dataclass(frozen=True, slots=True)
class Alike:
    """A suspect exchangeable for one of the best set. `share`: of what that set has with any of them in this place."""

    label: str
    share: float
    votes: Votes | None


@dataclass(frozen=True, slots=True)
class Name:
    """One suspect of the best set. `probability`: P(suspect ∈ S); `votes`: of either log, the other fitted, against the set without it."""

    suspect: Suspect
    probability: float
    alike: tuple[Alike, ...]
    confirmed: bool
    votes: Votes | None


@dataclass(frozen=True, slots=True)
class Said:
    """The outcome in words. `chosen`: the set that is written, `judged`: ln p(hold-out) of the rig file, of constants alone, of the chosen
    set; `judge`: what it prefers that one to. `all_logs`: those fitted, then the hold-out; `on_all`: sets as they are fitted to all of
    them, the chosen one and none among them."""

    word: str
    why: str
    chosen: Hypothesis
    names: tuple[Name, ...]
    none: float  # P(S = ∅)
    judged: Mapping[str, float]
    judge: tuple[Preference, ...]
    all_logs: Seen
    on_all: Mapping[frozenset[str], Hypothesis]

    @property
    def confirmed(self) -> bool:
        return all(n.confirmed for n in self.names) if self.names else self.word != "unknown" and self.none >= CONFIRMED


def said(search: EvidenceSearch, held: Sequence[Experiment], channels: Sequence[str]) -> Said:
    """Of a finished search; `held`: the hold-out logs, which only judge. `channels`: names of those compared."""
    judges = about(held, search.seen.scales, search.seen.model, search.seen.counts)
    everywhere, by_set = together(search.seen, judges), _judged(search, judges)
    found = of_all_logs(search, by_set, _nested(search, everywhere, by_set))
    named = [h for h in search.fitted if h.labels in by_set and h.suspects]
    chosen = search.null if found.none >= 0.5 or not named else max(named, key=lambda h: found.of_set[h.labels])
    judged = {
        "rig file": of_rig_file(search.nominal, search.seen, judges),
        "constants": by_set[search.null.labels].log_z - search.null.log_z,
        "chosen": by_set[chosen.labels].log_z - chosen.log_z,
    }
    left, doubt = (large(everywhere, by_set[chosen.labels], channels, most) for most in (UNEXPLAINED, MOST_HONEST))
    by_fit_logs = bool(beyond(search.seen, chosen, UNEXPLAINED).any())
    agreed = judged["chosen"] > judged["constants"] and not doubt
    fitted = {h.labels: h for h in search.fitted}
    ballot, judge = Ballot(search.seen, judges, fitted, by_set), preferences(fitted, by_set, chosen.labels, found.of_set)
    names = tuple(_name(found, chosen, s, agreed, ballot) for s in chosen.suspects)
    if names:
        word, why = _of_names(names, judge[0], left, doubt)
    else:
        word, why = _of_none(found, judged, left)
    return Said(word, advised(why, left, by_fit_logs), chosen, names, found.none, judged, judge, everywhere, by_set)


def _judged(search: EvidenceSearch, judges: Seen) -> dict[frozenset[str], Hypothesis]:
    """Sets fitted to all logs, small ones first; those that may be right to their end, with intervals that stand on it."""
    by_set: dict[frozenset[str], Hypothesis] = {}
    every = sorted(asked(search), key=lambda h: len(h.labels))
    for done in side_by_side(search.seen, lambda h: on_all_logs(search.seen, h, judges), every):
        parts = [h for labels, h in by_set.items() if labels < done.labels]
        best = max(parts, key=lambda h: h.log_z, default=done)
        by_set[done.labels] = led_by(search.seen, done, best, judges) if done.log_z < best.log_z + NEGLIGIBLE else done
    top = max(by_set.values(), key=search.log_mass)
    for part in _led_further(search, top, by_set, judges):
        by_set[part.labels] = led_by(search.seen, part, top, judges)
    found = of_all_logs(search, by_set)
    likely = [h for labels, h in by_set.items() if found.of_set[labels] >= 1.0 - CONFIRMED]
    ended = side_by_side(search.seen, lambda h: ended_on_all_logs(search.seen, h, judges), likely)
    return by_set | {h.labels: h for h in ended}


def _led_further(search: EvidenceSearch, top: Hypothesis, by_set: Mapping[frozenset[str], Hypothesis], judges: Seen) -> list[Hypothesis]:
    """The likeliest set less one suspect, unless it can hold no share of the posterior where it stands, nor where that set's own lines
    lead without the suspect. (They do not lead as far as a fit does: of EMPS' null bias they say too much.)"""
    less = [h for h in by_set.values() if h.labels < top.labels and len(h.labels) == len(top.labels) - 1]
    lines = {h.labels: h for h in nested(together(search.seen, judges), top, search.nominal.model)}
    least = search.log_mass(top) + NEGLIGIBLE
    return [part for part in less if max(search.log_mass(h) for h in (part, lines.get(part.labels, top))) > least]


def _nested(search: EvidenceSearch, everywhere: Seen, by_set: Mapping[frozenset[str], Hypothesis]) -> list[Hypothesis]:
    """Sets as those that may be right say that these are."""
    least = max(search.log_mass(h) for h in by_set.values()) + NEGLIGIBLE
    likely = [h for h in by_set.values() if search.log_mass(h) > least]
    return [part for parts in side_by_side(everywhere, lambda h: nested(everywhere, h, search.nominal.model), likely) for part in parts]


def asked(search: EvidenceSearch) -> list[Hypothesis]:
    """Sets that the hold-out is asked about: none, the best, the best less one, and one of another suspect in its place."""
    found, best = search.posterior, search.best
    beside = [h for h in search.fitted if len(h.labels ^ best.labels) <= 2 and found.of_set[h.labels] >= 1.0 - CONFIRMED]
    less = [h for h in search.fitted if h.labels < best.labels and len(h.labels) == len(best.labels) - 1]
    return list({h.labels: h for h in [search.null, best, *less, *beside]}.values())


def _name(found: Shares, chosen: Hypothesis, suspect: Suspect, judge_agrees: bool, ballot: Ballot) -> Name:
    probability, rest = found.of(suspect.label), chosen.labels - {suspect.label}
    group = found.in_place_of(chosen.labels, suspect.label)
    fitted = [(label, share) for label, share in group if label != suspect.label and ballot.fitted(rest | {label})]
    alike = tuple(Alike(label, share, ballot.votes(rest | {label}, rest)) for label, share in fitted)
    votes = ballot.votes(chosen.labels, rest)
    spoken_for = judge_agrees and votes is not None and votes.holdout > 0.0
    return Name(suspect, probability, alike, probability >= CONFIRMED and spoken_for, votes)


def _of_names(names: Sequence[Name], to_none: Preference, left: Sequence[str], doubt: Sequence[str]) -> tuple[str, str]:
    within = " if only known effects act" if left else ""
    listed = " and ".join(f"{n.suspect.label} (probability {probability(n.probability)}{within})" for n in names)
    side, them = "for" if to_none.gain > 0 else "against", "it" if len(names) == 1 else "them"
    judge = f"The hold-out, which was not fitted, speaks {side} {them}: {to_none.text()} over constants alone"
    if left:
        return "unknown", f"Something else acts: beside {listed} {', '.join(left)} stays, more than honest models leave. {judge}."
    judge += f". Not confirmed: {', '.join(doubt)} stays, so more may act" if doubt else ""
    sets = [f"{{{', '.join([n.suspect.label, *(other.label for other in n.alike)])}}}" for n in names if n.alike]
    if sets:
        return "ambiguous", f"These logs cannot tell apart {'; '.join(sets)}. Most probable: {listed}. {judge}."
    return "named", f"{listed}. {judge}."


def _of_none(found: Shares, judged: Mapping[str, float], left: Sequence[str]) -> tuple[str, str]:
    if left:
        return "unknown", f"Neither constants nor any known effect explain {', '.join(left)}: more is left than honest models leave."
    sure = f"that nothing is missing has a probability of {probability(found.none)}"
    gain = judged["constants"] - judged["rig file"]
    if gain <= np.log(1.0 / (1.0 - CONFIRMED)):
        return "no_gap", f"The rig file predicts the hold-out as well as refitted constants do (ln odds {gain:+.1f}); {sure}."
    return "parameter_mismatch", f"Other values of the rig's constants predict the hold-out better (ln odds {gain:+.1f}); {sure}."


def advised(why: str, left: Sequence[str], by_fit_logs: bool) -> str:
    """The reason, and what to do where something acts that the fit logs hardly show."""
    return f"{why} {_ONLY_HELD_OUT}" if left and not by_fit_logs else why


def large(all_logs: Seen, chosen: Hypothesis, channels: Sequence[str], most: float) -> list[str]:
    """Channels in which the chosen set, fitted to all logs, leaves more than `most` times the discrepancy that is expected: what the fit
    logs' motion does not show may act in the hold-out."""
    times = beyond(all_logs, chosen, most)
    return [f"{name} (discrepancy {r:.1f} times what is expected)" for name, r in zip(channels, times, strict=True) if r > 0.0]
