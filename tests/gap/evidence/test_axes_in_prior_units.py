"""Sensitivities along the axes of the posterior, of readings that are linear in the numbers: found exactly, whatever units priors have."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gap.evidence import sensitivity

Array = NDArray[np.float64]
NUMBERS, SAMPLES = 3, 50


def renewed(monkeypatch: pytest.MonkeyPatch, true: Array, old: Array, prior_precision: Array, nowhere: float = np.inf) -> Array:
    """Rows d readings / dφ as they are taken anew from `old` ones where moves beyond `nowhere` run away; unit noise."""

    def along(model: object, experiments: object, moves: Array) -> list[Array]:
        change = moves @ true
        change[np.max(np.abs(moves), axis=1) > nowhere] = np.nan
        return [change[:, None, :, None]]

    monkeypatch.setattr(sensitivity, "along", along)
    monkeypatch.setattr(sensitivity, "one_way", lambda *given: [np.empty((0, 1, SAMPLES, 1))])
    monkeypatch.setattr(sensitivity, "posterior", lambda seen, point: SimpleNamespace(precision=old @ old.T + np.diag(prior_precision)))
    monkeypatch.setattr(sensitivity, "phi_of", lambda model: np.zeros(NUMBERS))
    far = np.full(NUMBERS, 1e9)
    monkeypatch.setattr(sensitivity, "prior_of", lambda model: SimpleNamespace(precision=prior_precision, low=-far, high=far))
    experiment = SimpleNamespace(sigma=np.ones(1), measured=np.zeros((1, SAMPLES, 1)))
    point: Any = SimpleNamespace(model=None, readings=(np.zeros((1, SAMPLES, 1)),), jacobian=(old[:, None, :, None],))
    seen: Any = SimpleNamespace(experiments=(experiment,))
    (found,) = sensitivity._taken(seen, point, seen, point, np.ones(NUMBERS, dtype=bool), 1.0 + sensitivity._NOTHING)
    return np.asarray(found[:, 0, :, 0])


def lines(seed: int) -> Array:
    return np.random.default_rng(seed).normal(size=(NUMBERS, SAMPLES))


@pytest.mark.parametrize("precision", [1e-2, 1e-4])
def test_a_number_of_which_logs_know_more_than_its_prior_is_taken_anew(monkeypatch: pytest.MonkeyPatch, precision: float) -> None:
    """The last one: a size whose prior is a hundred or ten thousand of its units wide, of which the logs know a half of one."""
    true, old = lines(1), lines(2)
    old[2] *= 0.6 / np.linalg.norm(old[2])
    found = renewed(monkeypatch, true, old, np.array([1.0, 1.0, precision]))
    np.testing.assert_allclose(found, true, atol=1e-9)


def test_one_of_which_logs_know_nothing_keeps_what_it_had(monkeypatch: pytest.MonkeyPatch) -> None:
    true, old = lines(1), lines(2)
    old[2] *= 1e-3 / np.linalg.norm(old[2])
    found = renewed(monkeypatch, true, old, np.ones(NUMBERS))
    np.testing.assert_allclose(found[:2], true[:2], atol=0.05)
    assert np.linalg.norm(found[2] - true[2]) > 0.5 * np.linalg.norm(true[2])


def test_where_a_simulation_runs_away_what_was_known_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the softest axis alone, not of every number: moves along the others are short."""
    true, old = lines(3), lines(4)
    old[2] *= 0.1
    found = renewed(monkeypatch, true, old, np.full(NUMBERS, 1e-6), nowhere=1.5)
    assert np.all(np.isfinite(found))
    _, axes = np.linalg.eigh(old @ old.T + 1e-6 * np.eye(NUMBERS))
    np.testing.assert_allclose(axes[:, 1:].T @ found, axes[:, 1:].T @ true, atol=1e-9)
    np.testing.assert_allclose(axes[:, 0] @ found, axes[:, 0] @ old, atol=1e-9)
