"""What the verdict says where the hold-out shows less of a gap than the logs that were fitted."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.data.coarse_steps import CoarseStep
from gap.search.verdict import Verdict, verdict, with_steps


def of_log(name: str, cost: float) -> Any:
    """An evaluation of ten windows, all at this cost."""
    return SimpleNamespace(experiment=SimpleNamespace(log=SimpleNamespace(path=Path(name))), window_costs=np.full(10, cost))


def searched(rig_file: float, refitted: float) -> Any:
    """A search that named nothing: one quiet log, and one at these costs with the rig file and with its refitted constants."""
    model = SimpleNamespace(free=(), pulls=np.zeros(0))
    fits = [SimpleNamespace(evaluations=(of_log("a.mcap", 1.0), of_log("b.mcap", cost)), model=model) for cost in (rig_file, refitted)]
    return SimpleNamespace(steps=[], nominal=fits[0], current=fits[1], coarse=(), strained=())


def test_a_hold_out_without_a_gap_does_not_speak_for_a_fitted_log_that_has_one() -> None:
    word = verdict(searched(5.9, 5.5), 1.02, 1.01, 1.02)
    assert word.word == "unknown"
    assert "b.mcap only within 5.9" in word.why
    assert not word.confirmed


def test_no_gap_where_every_log_is_predicted() -> None:
    word = verdict(searched(1.04, 1.0), 1.02, 1.01, 1.02)
    assert (word.word, word.confirmed) == ("no_gap", True)


@pytest.mark.parametrize(("fitted", "confirmed"), [(1.1, True), (3.0, False)])
def test_constants_are_confirmed_only_where_they_explain_the_fitted_logs_too(fitted: float, confirmed: bool) -> None:
    word = verdict(searched(40.0, fitted), 20.0, 1.03, 1.03)
    assert (word.word, word.confirmed) == ("parameter_mismatch", confirmed)
    assert ("b.mcap" in word.why) is not confirmed


STEP = CoarseStep("axis.position", 73e-6, "m", 1e-6, 4000, 0.01)
SAID = "axis.position moves in steps of 7.3e-05 m, 73 times the 1e-06 m of the rig file: every value of every log lies on them."
WITH_STEPS = {"no_gap": "named", "parameter_mismatch": "named", "unknown": "unknown", "ambiguous": "ambiguous"}


@pytest.mark.parametrize("word", WITH_STEPS)
def test_steps_read_off_the_logs_are_named_beside_every_verdict(word: str) -> None:
    """They need no simulation; what the rest ends as stays said."""
    told = with_steps(Verdict(word, "The rest.", False), (STEP,))
    assert told == Verdict(WITH_STEPS[word], f"{SAID} The rest.", False)


def test_steps_change_nothing_where_the_data_cannot_be_used() -> None:
    fault = Verdict("data_problem", "Clipped.", False)
    assert with_steps(fault, (STEP,)) == fault
