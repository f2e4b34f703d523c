"""The evidence against exact marginal likelihoods: linear and normal in closed form, ends of ranges by quadrature; and how the log Bayes
factors of wrong effects scatter where nothing is missing."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import dblquad, quad
from scipy.stats import ks_1samp, multivariate_normal, ncx2

from config.loading.load import load_rig
from gap.evidence.score.coordinates import phi_of
from gap.evidence.score.laplace import added, log_evidence
from gap.evidence.score.prior import prior_of
from gap.fitting.model import Model
from gap.suspects.candidates import Candidate, candidates

WIDE = np.full(3, 1e6)
UNBOUNDED = np.full(1, -np.inf), np.full(1, np.inf)
Array = NDArray[np.float64]


def laplace(y: Array, j: Array, precision: Array, low: Array, high: Array, phi: Array) -> float:
    """Of y = J φ + white noise at a point φ, with normal priors about 0."""
    left = y - j.T @ phi
    density = -0.5 * (left @ left + np.sum(precision * phi**2)) + 0.5 * np.sum(np.log(precision))
    return log_evidence(float(density), j @ j.T + np.diag(precision), j @ left - precision * phi, phi, low, high)


def test_linear_and_normal_is_exact() -> None:
    draw = np.random.default_rng(1)
    j, precision = draw.normal(size=(3, 12)), np.array([1.0, 0.25, 4.0])
    y = draw.normal(size=12) * 2.0
    best = np.linalg.solve(j @ j.T + np.diag(precision), j @ y)
    exact = multivariate_normal(np.zeros(12), np.eye(12) + j.T @ np.diag(1 / precision) @ j).logpdf(y) + 6 * np.log(2 * np.pi)
    assert laplace(y, j, precision, -WIDE, WIDE, best) == pytest.approx(exact)


@pytest.mark.parametrize("sign", [1.0, 0.1, -1.0, -5.0])
def test_a_size_of_one_sign_against_quadrature(sign: float) -> None:
    """A half-normal prior: the data ask for a positive size, for next to none, or for a negative one that cannot be."""
    draw = np.random.default_rng(2)
    j = draw.normal(size=(1, 30))
    y = sign * 0.3 * j[0] + draw.normal(size=30)
    best = max(float(j[0] @ y / (j[0] @ j[0] + 0.1)), 0.0)

    def density(a: float) -> float:
        return float(np.exp(-0.5 * np.sum((y - a * j[0]) ** 2) - 0.05 * a**2 + 0.5 * y @ y) * 2 * np.sqrt(0.1 / (2 * np.pi)))

    exact = np.log(quad(density, 0.0, 30.0, points=[best], limit=200)[0]) - 0.5 * y @ y
    own = laplace(y, j, np.array([0.1]), np.zeros(1), np.full(1, 30.0), np.array([best])) + np.log(2.0)
    assert own == pytest.approx(exact, abs=1e-6)
    gain = added(j @ j.T, j @ y, np.zeros(1), np.full(1, np.inf), np.array([0.1]))
    assert gain == pytest.approx(exact + 0.5 * y @ y, abs=1e-6)


def test_one_number_more_by_schur_complement_is_the_ratio_of_exact_evidences() -> None:
    draw = np.random.default_rng(4)
    j, s, y = draw.normal(size=(3, 20)), draw.normal(size=20), draw.normal(size=20) * 1.5
    h = j @ j.T + np.eye(3)
    cross = j @ s
    inner = np.array([[s @ s - cross @ np.linalg.solve(h, cross)]])
    mixed = np.array([s @ y - cross @ np.linalg.solve(h, j @ y)])
    covariance = np.eye(20) + j.T @ j
    ratio = multivariate_normal(np.zeros(20), covariance + np.outer(s, s) / 0.2).logpdf(y) - multivariate_normal(
        np.zeros(20), covariance
    ).logpdf(y)
    assert added(inner, mixed, *UNBOUNDED, np.array([0.2])) == pytest.approx(ratio)


@pytest.mark.parametrize("strength", [0.0, 0.5, -0.5, 3.0])
def test_two_numbers_more_with_ends_against_quadrature(strength: float) -> None:
    """One of either sign, one of one sign; hardly correlated, so that what lies inside may be taken number by number."""
    draw = np.random.default_rng(6)
    s, precision = draw.normal(size=(2, 40)), np.array([0.3, 0.1])
    s[1] -= s[0] * (s[0] @ s[1]) / (s[0] @ s[0])
    y, low, high = strength * s[1] + draw.normal(size=40), np.array([-1.0, 0.0]), np.array([3.0, 9.0])

    def density(b: float, a: float) -> float:
        left = y - a * s[0] - b * s[1]
        return float(np.exp(-0.5 * (left @ left - y @ y) - 0.5 * (precision[0] * a**2 + precision[1] * b**2)))

    def prior(b: float, a: float) -> float:
        return float(np.exp(-0.5 * (precision[0] * a**2 + precision[1] * b**2)))

    exact = np.log(dblquad(density, -1.0, 3.0, 0.0, 9.0)[0] / dblquad(prior, -1.0, 3.0, 0.0, 9.0)[0])
    assert added(s @ s.T, s @ y, low, high, precision) == pytest.approx(exact, abs=2e-3)


def test_log_bayes_factors_of_wrong_effects_scatter_as_theory_says() -> None:
    """Nothing is missing: ln B = ½ χ²₁ (1 − λ/h) − ½ ln(h/λ), never more than rarely above 0."""
    draw = np.random.default_rng(8)
    precision, found, norms = 0.01, [], []
    for _ in range(2000):
        s, y = draw.normal(size=40), draw.normal(size=40)
        found.append(added(np.array([[s @ s]]), np.array([s @ y]), *UNBOUNDED, np.array([precision])))
        norms.append(float(s @ s))
    inner = np.array(norms)
    h = inner + precision
    chi2 = 2.0 * (np.array(found) + 0.5 * np.log(h / precision)) * h / inner
    assert ks_1samp(chi2, ncx2(1, 0.0).cdf).pvalue > 0.01
    assert np.mean(np.array(found) > 0.0) < 0.01  # χ²₁ > ln 4000 / …: 0.4 %


ORNL = load_rig("ornl_testbed")
CHANNELS = frozenset(ORNL.rig.plant.sensors)  # type: ignore[union-attr]
SUSPECTS = candidates(ORNL.rig, CHANNELS)


@pytest.mark.parametrize("suspect", SUSPECTS, ids=lambda one: one.label)
def test_logs_that_say_nothing_neither_speak_for_an_effect_nor_against_it(suspect: Candidate) -> None:
    """Whatever its range: its prior holds all its probability within the ends, so ln Z with it is that without."""
    model = Model(ORNL.rig, (), np.empty(0)).with_effect(suspect.entry, suspect.free)
    prior, phi = prior_of(model), phi_of(model)
    own = log_evidence(prior.log_density(phi), np.diag(prior.precision), -prior.precision * phi, phi, prior.low, prior.high)
    beyond = 3e-3 * len(phi)  # of a number at its end: what lies three standard deviations off, beyond the other
    assert own == pytest.approx(0.0, abs=beyond)
