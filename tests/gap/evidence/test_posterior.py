"""Shares of sets that were looked at beside two linearisations: the mean of both, and what is sure beside both stays sure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.evidence.judgement.posterior import shares
from gap.evidence.score.bootstrap import Weight

NONE, NAMED, OTHER = frozenset[str](), frozenset({"stiction at x"}), frozenset({"backlash at x"})
WINDOWS = 40


def fitted(labels: frozenset[str], log_z: float, windows: int = WINDOWS) -> Any:
    """What it has beside a ln Z of 0 comes from all windows alike, so that no bootstrap moves it."""
    return SimpleNamespace(labels=labels, log_z=log_z, windows=np.full(windows, log_z / windows))


def a_search(**log_z: float) -> Any:
    """Sets by the fit logs, with equal odds."""
    by_name = {"none": NONE, "named": NAMED, "other": OTHER}
    sets = [fitted(by_name[name], value, WINDOWS // 2) for name, value in log_z.items()]
    best = max(sets, key=lambda one: one.log_z)
    return SimpleNamespace(fitted=sets, waiting=[], best=best, weight=lambda h: Weight(h.log_z, h.windows), log_hope=None)


def odds(difference: float) -> float:
    """Of two sets; an event in a window, which no set foretells, takes up to 0.015 of that."""
    return 1.0 / (1.0 + np.exp(-difference))


@pytest.mark.parametrize(("once", "again"), [(2.5, -2.0), (1.0, 1.0), (-1.5, 2.5)])
def test_two_linearisations_have_equal_say(once: float, again: float) -> None:
    search = a_search(none=-20.0, named=-19.0)
    judged = {NONE: fitted(NONE, -50.0), NAMED: fitted(NAMED, -50.0 + once)}
    beside = {NONE: fitted(NONE, -70.0), NAMED: fitted(NAMED, -70.0 + again)}
    assert shares(search, judged).of("stiction at x") == pytest.approx(odds(once), abs=0.02)
    assert shares(search, judged, beside).of("stiction at x") == pytest.approx(0.5 * (odds(once) + odds(again)), abs=0.02)


def test_what_was_not_looked_at_again_keeps_its_distance() -> None:
    """Whatever the other linearisation does to all sets alike changes no share."""
    search = a_search(none=-20.0, named=-18.0, other=-19.0)
    judged = {NONE: fitted(NONE, -50.0), NAMED: fitted(NAMED, -48.0)}
    beside = {NONE: fitted(NONE, -90.0), NAMED: fitted(NAMED, -88.0)}
    once, twice = shares(search, judged), shares(search, judged, beside)
    for labels in (NONE, NAMED, OTHER):
        assert twice.of_set[labels] == pytest.approx(once.of_set[labels], abs=1e-9)
    assert sum(twice.of_set.values()) == pytest.approx(1.0)
