"""Where a discrepancy concentrates: residuals put by hand after the reversals of two windows of an axis are said to be there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.schema.rig import Rig
from gap.data.measured import on_grid
from gap.data.windows import prepare
from gap.evidence.noise.noise_model import Discrepancy
from gap.fitting.evaluation import Evaluation, evaluate
from gap.fitting.model import Model
from gap.outcome.unexplained import in_words, since_reversal, where_unexplained
from tests.support.gap import axis_logs

NAMES = ["axis.position"]
PERIOD_S, LENGTH_S = 0.002, 0.5
LATE_S = 0.06  # after a reversal, in which the residual is off


@pytest.fixture(scope="module")
def rig() -> Rig:
    return axis_logs.axis_rig()


def of_sine(rig: Rig) -> Evaluation:
    """A window a half period of 1 Hz, so that each has one reversal, in its middle; nothing is left but noise."""
    t = PERIOD_S * np.arange(round(10.0 / PERIOD_S))
    columns = {"t_s": t, "axis.position": 0.12 + 0.02 * np.sin(2.0 * np.pi * t), "axis.command_V": np.cos(2.0 * np.pi * t)}
    log = on_grid(Path("sine.csv"), columns, rig, "sine")
    found = evaluate(prepare(log, rig, {"axis.position": 2e-6}, LENGTH_S, NAMES), Model(rig, (), np.empty(0)), None)
    noise = np.random.default_rng(1).standard_normal(found.experiment.measured.shape)
    return with_left(found, noise)


def with_left(evaluation: Evaluation, left: np.ndarray) -> Evaluation:
    flat = np.zeros_like(evaluation.left)
    flat[:, : left[0].size] = left.reshape(len(left), -1)
    return replace(evaluation, left=flat)


def discrepancy(times: np.ndarray, sd: float = 3.0) -> Discrepancy:
    return Discrepancy(np.array([sd]), np.array([0.03]), 0.3, (times[:, None],))


def test_time_since_a_reversal_begins_where_the_velocity_changes_its_sign(rig: Rig) -> None:
    e = of_sine(rig)
    since = since_reversal(e, rig)["axis.since_reversal_s"]
    t = e.experiment.times_s
    true = np.mod(t - 0.25, 0.5)  # cos changes its sign at a quarter and three quarters of a second
    there = np.isfinite(since)
    assert there.mean() > 0.9  # but before the first
    assert np.median(np.abs(since[there] - true[there])) < 0.01  # the velocity is averaged, and slow motion keeps its sign


def test_what_is_left_after_reversals_of_two_windows_is_said_to_be_there(rig: Rig) -> None:
    e = of_sine(rig)
    since = since_reversal(e, rig)["axis.since_reversal_s"]
    left = e.left[:, : e.experiment.measured[0].size].reshape(e.experiment.measured.shape).copy()
    times, bad = np.full(len(left), 0.3), [4, 11]
    for window in bad:
        left[window, :, 0] += 30.0 * (since[window] < LATE_S)
        times[window] = 4.0
    (place,) = where_unexplained([with_left(e, left)], discrepancy(times), np.array([5.0]), NAMES, rig)
    assert place.channel == "axis.position"
    assert place.over is not None
    assert place.over.variable == "axis.since_reversal_s"
    assert place.over.low == 0.0
    assert place.over.high < 2.0 * LATE_S
    assert {w["from_s"] for w in place.windows} == {round(float(e.experiment.times_s[k, 0]), 3) for k in bad}
    assert "axis.since_reversal_s from 0 to" in in_words([place])


def test_channels_that_honest_models_leave_as_much_of_are_not_said(rig: Rig) -> None:
    e = of_sine(rig)
    assert where_unexplained([e], discrepancy(np.ones(e.experiment.windows)), np.array([0.0]), NAMES, rig) == []
    assert in_words([]) == ""
