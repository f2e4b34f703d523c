"""Telling two explanations apart: window by window, and log by log where there are several."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.fitting.compare import paired_t, separation_t


def log(costs: np.ndarray) -> Any:
    """As much of an evaluation as is looked at: costs of windows of 70 values each."""
    return SimpleNamespace(window_costs=costs, experiment=SimpleNamespace(measured=np.zeros((len(costs), 70, 1))))


def logs(means: list[float], seed: int) -> list[Any]:
    draw = np.random.default_rng(seed)
    return [log(mean * draw.lognormal(0, 0.3, 24)) for mean in means]


def test_logs_that_disagree_do_not_separate_though_their_windows_do() -> None:
    """Three logs for one explanation, one against it: the windows are many, the logs are not."""
    worse, better = logs([550, 750, 340, 370], 1), logs([180, 160, 820, 150], 2)
    assert paired_t(worse, better) > 3
    assert separation_t(worse, better) < 3


def test_logs_that_agree_separate() -> None:
    worse, better = logs([550, 750, 800, 600], 1), logs([200, 250, 300, 220], 2)
    assert separation_t(worse, better) > 3


def test_a_log_that_tells_little_does_not_disagree_where_nothing_is_left() -> None:
    """As in a loop: the first hold-out beside two runs of the maneuver that separates; one explanation is at the floor in all."""
    draw = np.random.default_rng(3)
    worse, better = ([log(mean * draw.lognormal(0, 0.1, 24)) for mean in means] for means in ([1.06, 4.4, 4.3], [0.97, 0.98, 0.97]))
    assert separation_t(worse, better) == paired_t(worse, better) > 3
    open_ = [log(1.3 * one.window_costs) for one in better]
    assert separation_t([log(1.3 * one.window_costs) for one in worse], open_) < 3


def test_one_or_two_logs_are_judged_by_their_windows() -> None:
    worse, better = logs([550, 300], 1), logs([200, 320], 2)
    assert separation_t(worse, better) == paired_t(worse, better)


def test_exact_windows_have_no_vote_that_is_no_number() -> None:
    still, moved = log(np.zeros(24)), log(np.r_[np.zeros(12), np.full(12, 5.0)])
    assert np.isfinite(separation_t([moved], [still]))
    assert paired_t([still], [still]) == pytest.approx(0.0)
