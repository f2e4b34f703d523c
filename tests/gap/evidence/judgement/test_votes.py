"""The two votes on a name, against the marginal likelihoods of a linear problem; the descents are replaced by its closed forms."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from gap.evidence.judgement import votes
from gap.evidence.judgement.votes import Ballot

NAME, NONE = frozenset({"friction at axis"}), frozenset[str]()
SAMPLES = 40


def log_z(columns: np.ndarray, y: np.ndarray) -> float:
    """Of readings that hang on numbers with standard normal priors, in white noise."""
    return float(multivariate_normal(np.zeros(len(y)), np.eye(len(y)) + columns @ columns.T).logpdf(y))


def ballot(monkeypatch: pytest.MonkeyPatch, y: np.ndarray) -> Ballot:
    """Two logs of 40 samples each: a constant and, in the larger set, an effect."""
    columns = np.random.default_rng(2).standard_normal((2 * SAMPLES, 2))
    of_set = {NONE: columns[:, :1], NAME: columns}

    def of(labels: frozenset[str], rows: slice) -> Any:
        return SimpleNamespace(labels=labels, log_z=log_z(of_set[labels][rows], y[rows]))

    whole, first, second = slice(None), slice(0, SAMPLES), slice(SAMPLES, None)
    monkeypatch.setattr(votes, "on_hold_out", lambda seen, judged, held: of(judged.labels, second))
    fitted, on_all = ({labels: of(labels, rows) for labels in of_set} for rows in (first, whole))
    return Ballot(SimpleNamespace(threads=2), None, fitted, on_all)  # type: ignore[arg-type]


def predictive(y: np.ndarray, judge: slice, fitted: slice, numbers: int) -> float:
    """ln p(one log | the other), by the normal posterior of the numbers."""
    columns = np.random.default_rng(2).standard_normal((2 * SAMPLES, 2))[:, :numbers]
    j, h = columns[fitted], columns[judge]
    covariance = np.linalg.inv(j.T @ j + np.eye(numbers))
    mean = h @ covariance @ j.T @ y[fitted]
    return float(multivariate_normal(mean, np.eye(SAMPLES) + h @ covariance @ h.T).logpdf(y[judge]))


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (1.0, -1.0), (0.0, 0.0)])
def test_each_vote_is_the_predictive_density_of_the_log_that_was_not_fitted(
    monkeypatch: pytest.MonkeyPatch, sizes: tuple[float, float]
) -> None:
    columns = np.random.default_rng(2).standard_normal((2 * SAMPLES, 2))
    y = np.random.default_rng(4).standard_normal(2 * SAMPLES) + 0.5 * columns[:, 0]
    y += np.repeat(sizes, SAMPLES) * columns[:, 1]
    found = ballot(monkeypatch, y).votes(NAME, NONE)
    assert found is not None
    a, b = slice(0, SAMPLES), slice(SAMPLES, None)
    assert found.holdout == pytest.approx(predictive(y, b, a, 2) - predictive(y, b, a, 1))
    assert found.fit_logs == pytest.approx(predictive(y, a, b, 2) - predictive(y, a, b, 1))
    if sizes == (1.0, 1.0):
        assert min(found.holdout, found.fit_logs) > 5.0
    if sizes == (1.0, -1.0):  # each log wants the name, with another size
        assert max(found.holdout, found.fit_logs) < 0.0


def test_a_set_that_the_hold_out_was_not_asked_about_has_no_votes(monkeypatch: pytest.MonkeyPatch) -> None:
    assert ballot(monkeypatch, np.zeros(2 * SAMPLES)).votes(frozenset({"valve_lag at axis"}), NONE) is None
