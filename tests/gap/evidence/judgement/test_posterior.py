"""Shares of sets, those fitted to all logs and those that were not."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.evidence.judgement import words
from gap.evidence.judgement.posterior import of_all_logs
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import _awaited
from tests.support.gap.bare_fit import WINDOWS
from tests.support.gap.bare_fit import bare_fit as fitted

NONE, NAMED, OTHER = frozenset[str](), frozenset({"stiction at x"}), frozenset({"backlash at x"})
SETS = {"none": NONE, "named": NAMED, "other": OTHER}


def a_search(waiting: dict[frozenset[str], float] | None = None, **log_z: float) -> EvidenceSearch:
    """Sets by the fit logs, with equal odds; `waiting`: what others promise to gain over none."""
    unseen: Any = None
    sets = tuple(fitted(SETS[name], value, WINDOWS // 2) for name, value in log_z.items())
    promised: Any = [SimpleNamespace(base=fitted(NONE, 0.0), labels=labels, gain=gain) for labels, gain in (waiting or {}).items()]
    return EvidenceSearch(unseen, frozenset(), unseen, unseen, sets, tuple(promised), 0.0)


def odds(difference: float) -> float:
    """Of two sets; an event in a window, which no set foretells, takes up to 0.015 of that."""
    return 1.0 / (1.0 + np.exp(-difference))


@pytest.mark.parametrize("gained", [2.5, 1.0, -1.5])
def test_shares_are_those_of_all_logs(gained: float) -> None:
    search = a_search(none=-20.0, named=-19.0)
    judged = {NONE: fitted(NONE, -50.0), NAMED: fitted(NAMED, -50.0 + gained)}
    assert of_all_logs(search, judged).of("stiction at x") == pytest.approx(odds(gained), abs=0.02)


def test_a_set_that_the_hold_out_was_not_asked_about_gains_with_it_what_the_best_one_does() -> None:
    search = a_search(none=-20.0, named=-18.0, other=-19.0)
    once, far = (of_all_logs(search, {NONE: fitted(NONE, -50.0 + z), NAMED: fitted(NAMED, -48.0 + z)}) for z in (0.0, -40.0))
    for labels in (NONE, NAMED, OTHER):
        assert far.of_set[labels] == pytest.approx(once.of_set[labels], abs=1e-9)
    assert once.of_set[OTHER] / once.of_set[NAMED] == pytest.approx(np.exp(-1.0), abs=0.03)
    assert sum(once.of_set.values()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("promised", "none", "asked"),
    [
        (5.0, -20.0, True),  # 0.03 of what the best set has: it would be sure without
        (3.0, -20.0, False),  # it is sure also beside that
        (5.0, 5.0, False),  # what is fitted keeps it from being sure anyway
    ],
)
def test_what_a_promise_would_decide_is_asked_for(promised: float, none: float, asked: bool) -> None:
    search = a_search({OTHER: promised - none, NAMED | OTHER: promised - none}, none=none, named=8.5)
    awaited = _awaited(search)
    assert (awaited is not None) is asked
    if awaited is not None:
        assert awaited.labels == OTHER  # the larger set has the name too


@pytest.mark.parametrize(
    ("stands", "lines", "led"),
    [
        (-1.0, -60.0, True),  # a share where it stands: it may gain more than lines say
        (-60.0, -1.0, True),  # a share where the lines lead
        (-60.0, None, True),  # no line leads there: of a link that bends to a rigid one
        (-60.0, -900.0, False),
    ],
)
def test_a_smaller_set_is_led_on_unless_it_can_hold_no_share_either_way(
    monkeypatch: pytest.MonkeyPatch, stands: float, lines: float | None, led: bool
) -> None:
    nothing: Any = SimpleNamespace(model=None)
    monkeypatch.setattr(words, "together", lambda *_: None)
    monkeypatch.setattr(words, "nested", lambda *_: [] if lines is None else [fitted(NONE, lines)])
    search, top = replace(a_search(), nominal=nothing), fitted(NAMED, 0.0)
    by_set = {NONE: fitted(NONE, stands), NAMED: top, OTHER: fitted(OTHER, 0.0)}
    assert [h.labels for h in words._led_further(search, top, by_set, nothing)] == ([NONE] if led else [])


@pytest.mark.parametrize(
    ("promised", "asked"),
    [
        (28.4, True),  # a tenth of what the best set has: it would be a look-alike
        (25.5, False),  # 0.005
    ],
)
def test_no_look_alike_is_said_that_was_not_fitted(promised: float, asked: bool) -> None:
    search = a_search({OTHER: promised}, none=0.0, named=30.6)
    search = replace(search, fitted=(*search.fitted, fitted(frozenset({"valve_lag at x"}), 29.0, WINDOWS // 2)))  # not confirmed either way
    awaited = _awaited(search)
    assert (awaited is not None) is asked
    if awaited is not None:
        assert awaited.labels == OTHER
