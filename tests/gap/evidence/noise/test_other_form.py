"""The part of the friction that has another form: against quadrature over a dense Σ; where nothing tells, what was expected before."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.stats import halfnorm, multivariate_normal

from gap.evidence.deciding_numbers import OTHER_FORM
from gap.evidence.noise.noise_model import Discrepancy
from gap.evidence.noise.other_form import expected_form
from gap.evidence.noise.unknowns import Unknowns
from gap.evidence.noise.whitening import Whitening

WHITE = Discrepancy(np.array([1e-3]), np.array([0.03]), 0.3)


def windows(forms: NDArray[np.float64], left: NDArray[np.float64]) -> list[Whitening]:
    """A log of one channel in white noise of 1. `forms`: numbers × windows × samples."""
    plan = SimpleNamespace(every=3, period_s=0.001, rows=3 * left.shape[1])
    e = SimpleNamespace(workers=1, measured=left[..., None], sigma=np.ones(1), plan=plan, windows=len(left))
    return [Whitening(cast(Any, e), Unknowns(np.zeros((0, *left.shape, 1)), forms[..., None]))]


def expected(density: Any) -> float:
    """Mean of η² / (η² + OTHER_FORM²) over η with its half-normal prior and a density."""
    prior = halfnorm(scale=OTHER_FORM)

    def over_shares(value: Any) -> float:
        points = [0.03, 0.1, 0.3, 1.0]
        return float(quad(lambda e: prior.pdf(e) * density(e) * value(e), 0.0, 3.0, points=points, limit=200)[0])

    return over_shares(lambda e: e**2 / (e**2 + OTHER_FORM**2)) / over_shares(lambda e: 1.0)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.3, 1.0])
def test_it_is_the_mean_over_what_the_logs_say_of_the_share(share: float) -> None:
    draw = np.random.default_rng(5)
    forms = 2.0 * draw.normal(size=(6, 4, 10))
    left = draw.normal(size=(4, 10)) + np.tensordot(share * np.array([1.0, -1.0] * 3), forms, 1)
    flat, r = forms.reshape(6, 40), left.ravel()

    def density(eta: float) -> float:
        sigma = np.eye(40) + eta**2 * flat.T @ flat
        return float(np.exp(multivariate_normal(np.zeros(40), sigma).logpdf(r) - reference))

    reference = max(multivariate_normal(np.zeros(40), np.eye(40) + e**2 * flat.T @ flat).logpdf(r) for e in np.geomspace(1e-3, 3.0, 50))
    assert expected_form(windows(forms, left), [left[..., None]], WHITE) == pytest.approx(expected(density), rel=0.02, abs=1e-4)


def test_where_other_forms_change_nothing_it_is_what_was_expected_beforehand() -> None:
    """Of a friction that hardly yields before it slides; the likeliest η is 0 there."""
    left = np.random.default_rng(6).normal(size=(40, 20))
    forms = np.full((6, 40, 20), 1e-6)
    assert expected_form(windows(forms, left), [left[..., None]], WHITE) == pytest.approx(expected(lambda eta: 1.0), rel=0.02)


def test_where_nothing_rubs_it_is_none() -> None:
    left = np.random.default_rng(7).normal(size=(4, 20))
    assert expected_form(windows(np.zeros((0, 4, 20)), left), [left[..., None]], WHITE) == 0.0
