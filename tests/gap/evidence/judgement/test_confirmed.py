"""A name is confirmed if it is probable enough, the whole set is borne out, and the hold-out by itself speaks for that name."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.evidence.deciding_numbers import UNEXPLAINED
from gap.evidence.judgement.preference import Preference
from gap.evidence.judgement.votes import Votes
from gap.evidence.judgement.words import Name, _name, _of_names, advised, large
from gap.evidence.score.hypothesis import MOST_HONEST
from gap.evidence.score.shares import Shares

PAIR, ONE = frozenset({"stiction at x", "valve_deadband at x"}), frozenset({"stiction at x"})


class Asked:
    """A ballot of one answer; remembers between which sets it was asked."""

    def __init__(self, holdout: float | None) -> None:
        self._holdout = holdout
        self.asked: list[tuple[frozenset[str], frozenset[str]]] = []

    def fitted(self, labels: frozenset[str]) -> bool:
        return True

    def votes(self, with_it: frozenset[str], without: frozenset[str]) -> Votes | None:
        self.asked.append((with_it, without))
        return None if self._holdout is None else Votes(self._holdout, 20.0)


@pytest.mark.parametrize(
    ("share", "borne_out", "holdout", "confirmed"),
    [
        (0.995, True, 12.0, True),
        (0.985, True, 12.0, False),  # not probable enough
        (0.995, False, 12.0, False),  # the set as a whole, or something else acts
        (0.995, True, -29.0, False),  # the hold-out is worse off with this name than without it
        (0.995, True, None, False),  # not asked
    ],
)
def test_every_name_needs_the_hold_outs_own_vote(share: float, borne_out: bool, holdout: float | None, confirmed: bool) -> None:
    found = Shares({PAIR: share, ONE: 1.0 - share})
    chosen: Any = SimpleNamespace(labels=PAIR)
    suspect: Any = SimpleNamespace(label="valve_deadband at x")
    ballot: Any = Asked(holdout)
    name = _name(found, chosen, suspect, borne_out, ballot)
    assert name.confirmed is confirmed
    assert name.probability == pytest.approx(share)
    assert ballot.asked[-1] == (PAIR, ONE)


@pytest.mark.parametrize(
    ("left", "by_fit_logs", "told"), [(["x.position"], False, True), (["x.position"], True, False), ([], False, False)]
)
def test_what_the_hold_out_alone_shows_is_to_be_fitted(left: list[str], by_fit_logs: bool, told: bool) -> None:
    assert ("fit the hold-out too, and hold out another log" in advised("Something else acts.", left, by_fit_logs)) is told


@pytest.mark.parametrize(
    ("times", "in_doubt", "unknown"),
    [
        (2.5, False, False),
        (2.7, True, False),  # a name is said, and not confirmed
        (3.9, True, False),
        (4.1, True, True),
    ],
)
def test_a_large_discrepancy_is_doubt_and_a_very_large_one_unknown(times: float, in_doubt: bool, unknown: bool) -> None:
    scales = np.array([0.3, 0.8])
    seen: Any = SimpleNamespace(scales=scales)
    chosen: Any = SimpleNamespace(at=SimpleNamespace(discrepancy=SimpleNamespace(sd=scales * [1.0, times])))
    left, doubt = (large(seen, chosen, ["rotary.position", "tip.deflection"], most) for most in (UNEXPLAINED, MOST_HONEST))
    told = [f"tip.deflection (discrepancy {times:.1f} times what is expected)"]
    assert left == (told if unknown else [])
    assert doubt == (told if in_doubt else [])
    name = Name(SimpleNamespace(label="gravity at rotary"), 0.999, (), False, None)  # type: ignore[arg-type]
    word, why = _of_names([name], Preference(frozenset(), 12.0, 5.0, 20.0), left, doubt)
    assert ("if only known effects act" in why) is unknown
    assert word == ("unknown" if unknown else "named")
    assert ("Not confirmed: tip.deflection" in why) is (in_doubt and not unknown)
