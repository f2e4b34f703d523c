"""What is left over is described by the input that carries it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap.remainder import remainder as subject
from gap.remainder.remainder import remainder, sentence

WINDOWS, SAMPLES = 40, 70


def evaluation(left: np.ndarray) -> Any:
    """As much of an evaluation as is looked at, of one channel."""
    cost = float(np.mean(left**2))
    experiment = SimpleNamespace(measured=np.zeros((*left.shape, 1)), times_s=np.arange(left.size).reshape(left.shape) * 1e-3, log=None)
    return SimpleNamespace(left=left, experiment=experiment, window_costs=np.full(WINDOWS, cost), channel_costs=np.array([cost]))


@pytest.fixture
def velocity(monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    draw = np.random.default_rng(1)
    values = np.repeat(draw.normal(size=(WINDOWS, 1)), SAMPLES, axis=1)
    other = draw.normal(size=(WINDOWS, SAMPLES))
    monkeypatch.setattr(subject, "discrepancy", lambda logs, rig: None)
    monkeypatch.setattr(subject, "operating_values", lambda e, rig: {"axis.velocity": values, "axis.command_V": other})
    return values


def test_the_input_that_carries_the_rest_is_named_with_its_share(velocity: np.ndarray) -> None:
    noise = np.random.default_rng(2).normal(size=velocity.shape)
    left = noise + 2.0 * np.sign(velocity)  # 4/5 of the variance
    found = remainder([evaluation(10 * left)], [evaluation(left)], ["axis.position"], None)  # type: ignore[arg-type]
    assert found is None  # a hundredth of the gap
    found = remainder([evaluation(2 * left)], [evaluation(left)], ["axis.position"], None)  # type: ignore[arg-type]
    assert found is not None
    assert found["channel"] == "axis.position"
    assert found["excess"] == pytest.approx(np.mean(left**2) - 1, rel=1e-3)
    first = found["carried_by"][0]
    assert first["input"] in ("sign of axis.velocity", "axis.velocity")
    assert first["share"] == pytest.approx(0.8, abs=0.04)
    assert "axis.velocity (8" in sentence(found)


def test_white_noise_is_carried_by_nothing(velocity: np.ndarray) -> None:
    left = 2.0 * np.random.default_rng(3).normal(size=velocity.shape)
    found = remainder([evaluation(left)], [evaluation(left)], ["axis.position"], None)  # type: ignore[arg-type]
    assert found is not None
    assert found["carried_by"] == []
