"""Telling two explanations apart: window by window, and log by log where there are several."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.fitting.compare import paired_t


def log(costs: np.ndarray) -> Any:
    """As much of an evaluation as is looked at: costs of windows of 70 values each."""
    return SimpleNamespace(window_costs=costs, experiment=SimpleNamespace(measured=np.zeros((len(costs), 70, 1))))


def logs(means: list[float], seed: int) -> list[Any]:
    draw = np.random.default_rng(seed)
    return [log(mean * draw.lognormal(0, 0.3, 24)) for mean in means]


def test_one_explanation_that_costs_three_times_the_other_is_told_apart() -> None:
    worse, better = logs([550, 750, 800, 600], 1), logs([200, 250, 300, 220], 2)
    assert paired_t(worse, better) > 3
    assert paired_t(better, worse) == pytest.approx(-paired_t(worse, better), rel=0.2)


def test_exact_windows_have_no_vote_that_is_no_number() -> None:
    still, moved = log(np.zeros(24)), log(np.r_[np.zeros(12), np.full(12, 5.0)])
    assert np.isfinite(paired_t([moved], [still]))
    assert paired_t([still], [still]) == pytest.approx(0.0)
