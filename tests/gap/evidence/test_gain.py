"""What is promised along straight lines is the suspect's only beyond what a descent reaches without it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gap.evidence.search_state import Open
from tests.support.gap.bare_fit import bare_fit

START = -1000.0  # ln Z


def gain(*, beside: float, along: float, lines_alone: float, level: float) -> float:
    """All above ln Z of the start: what is promised beside the old discrepancy and along lines, what lines alone reach, and a descent."""
    promise: Any = SimpleNamespace(suspect=SimpleNamespace(label="leak"), log_z=START + beside)
    lines: Any = SimpleNamespace(log_z=START + along)
    return Open(bare_fit(set(), START), promise, lines, (START, START + lines_alone), START + level).gain


def test_lines_that_reach_what_a_descent_reaches_are_believed() -> None:
    assert gain(beside=17.0, along=130.0, lines_alone=90.0, level=90.0) == pytest.approx(40.0)


def test_what_lines_miss_by_themselves_is_no_gain() -> None:
    """Case 0113 of the second study: lines missed 792, promised a hose's compliance 68, and a fit with it lost 2.5."""
    assert gain(beside=0.4, along=168.0, lines_alone=100.0, level=892.0) == pytest.approx(0.4)


def test_what_is_more_than_lines_miss_stays_the_suspects() -> None:
    """Case 0084: lines missed 108 and promised the right suspect 496; a fit with it ended 649 higher."""
    assert gain(beside=20.0, along=1096.0, lines_alone=600.0, level=708.0) == pytest.approx(388.0)


def test_lines_that_promise_more_without_the_suspect_than_a_descent_holds_are_their_own_measure() -> None:
    assert gain(beside=0.0, along=130.0, lines_alone=120.0, level=90.0) == pytest.approx(10.0)
