"""Shares of sets, those fitted to all logs and those that were not."""

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


@pytest.mark.parametrize("gained", [2.5, 1.0, -1.5])
def test_shares_are_those_of_all_logs(gained: float) -> None:
    search = a_search(none=-20.0, named=-19.0)
    judged = {NONE: fitted(NONE, -50.0), NAMED: fitted(NAMED, -50.0 + gained)}
    assert shares(search, judged).of("stiction at x") == pytest.approx(odds(gained), abs=0.02)


def test_a_set_that_the_hold_out_was_not_asked_about_gains_with_it_what_the_best_one_does() -> None:
    search = a_search(none=-20.0, named=-18.0, other=-19.0)
    once, far = (shares(search, {NONE: fitted(NONE, -50.0 + z), NAMED: fitted(NAMED, -48.0 + z)}) for z in (0.0, -40.0))
    for labels in (NONE, NAMED, OTHER):
        assert far.of_set[labels] == pytest.approx(once.of_set[labels], abs=1e-9)
    assert once.of_set[OTHER] / once.of_set[NAMED] == pytest.approx(np.exp(-1.0), abs=0.03)
    assert sum(once.of_set.values()) == pytest.approx(1.0)
