"""Which first trials are fitted further: a rival of the same signature is never dropped for a first fit that ended far off."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.gap.look_alike_cases import ONE_WAY
from benchmarks.gap.look_alikes import hidden_and_logged
from gap.find import find
from gap.search.select import CONTENDER, LEADING, _contenders
from gap.search.settings import Settings
from gap.signatures.screen import Screening

NAMES = ("lag", "delay", "stiction", "gravity")


def trial(name: str, gain: float) -> Any:
    return SimpleNamespace(candidate=candidate(name), gain=gain)


def candidate(name: str) -> Any:
    return SimpleNamespace(effect=name, where="axis", label=f"{name} at axis")


def screening(alike: float) -> Screening:
    """Lag and delay nearly or not at all in one direction."""
    cosines = np.eye(4)
    cosines[0, 1] = cosines[1, 0] = alike
    signatures: Any = tuple(SimpleNamespace(candidate=candidate(name)) for name in NAMES)
    return Screening(signatures, cosines)


@pytest.mark.parametrize(("alike", "expected"), [(0.99, ["lag", "delay"]), (-0.99, ["lag", "delay"]), (0.5, ["delay"])])
def test_where_one_solves_the_gap_all_of_its_signature_are_fitted_on(alike: float, expected: list[str]) -> None:
    trials = [trial("lag", -3.0), trial("delay", 0.97), trial("stiction", 0.1), trial("gravity", CONTENDER * 0.97 - 0.01)]
    assert [t.candidate.effect for t in _contenders(trials, screening(alike), solved=True)] == expected


def test_where_none_does_the_first_signatures_are() -> None:
    trials = [trial(name, gain) for name, gain in zip(NAMES, (-3.0, 0.0, 0.4, 0.35), strict=True)]
    chosen = [t.candidate.effect for t in _contenders(trials, screening(0.99), solved=False)]
    assert chosen == [*NAMES[:LEADING], "stiction", "gravity"]


def test_no_trials_no_contenders() -> None:
    assert _contenders([], screening(0.0), solved=False) == []


@pytest.mark.slow
@pytest.mark.parametrize("time_constant", ["3 ms", "2 ms"])
def test_a_lag_is_not_taken_for_a_delay(tmp_path: Path, time_constant: str) -> None:
    """Two logs that move one way and hardly show it; both seen as a delay alone, confirmed, before. The first fit of the larger ends far
    off; the smaller has no size, since time constant and damping take each other's place."""
    number = next(k for k, case in enumerate(ONE_WAY.cases) if f"time_constant: {time_constant}, damping_ratio: 0.7" in case)
    _, logs, _ = hidden_and_logged(ONE_WAY, ONE_WAY.cases[number], 1000 + 10 * number, tmp_path)
    found = find(tmp_path / "model.yaml", logs[:1], logs[1:], tmp_path / "out", lambda line: None, Settings(propose=False))
    (named,) = found.content["findings"]
    assert not named["confirmed"]
    assert {named["effect"], *(rival["effect"] for rival in named["look_alikes"])} == {"valve_lag", "transport_delay"}
    assert all(rival["holdout_gain"] > 0.5 for rival in named["look_alikes"])
