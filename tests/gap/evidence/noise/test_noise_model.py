"""Σ in O(n) against the same Σ as a dense matrix: determinant, quadratic form, products with columns, missing samples,
unknowns of every window and shared ones, windows that are more wrong than others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.stats import multivariate_normal

from gap.evidence.noise.discrepancy_search import fitted_discrepancy, on_other_logs
from gap.evidence.noise.noise_model import Discrepancy, by_window, weighed
from gap.evidence.noise.ornstein_uhlenbeck import at_rung, filter_of, rung
from gap.evidence.noise.unknowns import Unknowns
from gap.evidence.noise.whitening import Whitening

PERIOD_S = 0.003


class Plan:
    """What the noise model asks of a log's plan."""

    every, period_s, rows = 3, 0.001, 60


class Log:
    """What the noise model asks of an experiment."""

    workers = 2

    def __init__(self, measured: NDArray[np.float64], sigma: NDArray[np.float64]) -> None:
        self.measured, self.sigma, self.plan, self.windows = measured, sigma, Plan(), len(measured)


def dense(there: NDArray[np.bool_], sd: float, time_s: float) -> NDArray[np.float64]:
    """1 + δ² exp(−|t − t'| / T) of the samples that are there."""
    t = PERIOD_S * np.flatnonzero(there)
    return np.asarray(np.eye(len(t)) + sd**2 * np.exp(-np.abs(t[:, None] - t[None, :]) / time_s))


@pytest.mark.parametrize("sd", [0.0, 0.05, 1.0, 40.0])
@pytest.mark.parametrize("time_s", [0.001, 0.02, 3.0])
def test_filter_gives_square_root_and_inverse_of_the_dense_covariance(sd: float, time_s: float) -> None:
    draw = np.random.default_rng(3)
    there = draw.random((4, 25, 2)) > 0.3
    there[1], there[2, :, 0] = True, False  # a whole window, and one with a channel that was never measured
    made = filter_of(there, np.array([sd, 0.7]), np.array([time_s, 0.01]), PERIOD_S)
    rows = np.where(there, draw.normal(size=(3, 4, 25, 2)), 0.0)
    white, solved = (found.reshape(4, 25, 2, 3).transpose(3, 0, 1, 2) for found in made.applied(rows))
    for w in range(4):
        for c, (own_sd, own_time) in enumerate(((sd, time_s), (0.7, 0.01))):
            covariance = dense(there[w, :, c], own_sd, own_time)
            assert made.log_det[w, c] == pytest.approx(np.linalg.slogdet(covariance)[1], abs=1e-9)
            own = rows[:, w, there[w, :, c], c]
            inner = own @ np.linalg.solve(covariance, own.T)
            np.testing.assert_allclose(white[:, w, :, c] @ white[:, w, :, c].T, inner, atol=1e-8)
            np.testing.assert_allclose(solved[:, w, :, c] @ rows[:, w, :, c].T, inner, atol=1e-8)


def on_ladder(*values: float) -> NDArray[np.float64]:
    """The nearest values that δ, T and the times of windows may have."""
    return at_rung(rung(np.array(values)))


def alone(left: NDArray[np.float64], unknowns: Unknowns) -> Whitening:
    """One log, whose noise has the standard deviation 1."""
    return Whitening(cast(Any, Log(left, np.ones(1))), unknowns)


def log(draw: np.random.Generator) -> tuple[Any, Unknowns]:
    """Five windows, two channels, some samples missing; three unknowns of each window and two that all share."""
    measured = draw.normal(size=(5, 20, 2))
    measured[0, 3:6, 1] = measured[2, 0, 0] = np.nan
    there = np.isfinite(measured)
    states, forms = (np.where(there, draw.normal(size=(n, 5, 20, 2)), 0.0) for n in (3, 2))
    return Log(measured, np.array([0.5, 2.0])), Unknowns(states, forms)


def dense_of_window(e: Any, unknowns: Unknowns, w: int, sd: NDArray[np.float64], time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """C + A Aᵀ of one window's samples that are there, channels side by side; `sd`, `time_s`: one a channel."""
    there, full = np.isfinite(e.measured[w]), np.zeros((40, 40))
    for c in range(2):
        at = 2 * np.flatnonzero(there[:, c]) + c
        full[np.ix_(at, at)] = dense(there[:, c], float(sd[c]), float(time_s[c]))
    a, keep = unknowns.states[:, w].reshape(3, 40), there.ravel()
    return np.asarray((full + a.T @ a)[np.ix_(keep, keep)])


@pytest.mark.parametrize(("contacts", "scales"), [(0, (0.7, 0.7)), (1, (0.7, 0.2))])
def test_two_logs_with_unknowns_of_their_own_and_shared_against_one_dense_matrix(contacts: int, scales: tuple[float, float]) -> None:
    draw = np.random.default_rng(5)
    logs, unknowns = zip(*(log(draw) for _ in range(2)), strict=True)
    unknowns = tuple(replace(own, contacts=contacts) for own in unknowns)
    discrepancy = Discrepancy(on_ladder(0.8, 3.0), on_ladder(0.03, 0.006), 0.7, contact=0.2)
    rows = [np.where(np.isfinite(e.measured), draw.normal(size=(4, *e.measured.shape)), 0.0) for e in logs]
    made = weighed([Whitening(*own) for own in zip(logs, unknowns, strict=True)], [[own] for own in rows], discrepancy)
    blocks, flat, forms = [], [], []
    for e, known, own in zip(logs, unknowns, rows, strict=True):
        for w in range(5):
            keep = np.isfinite(e.measured[w]).ravel()
            blocks.append(dense_of_window(e, known, w, discrepancy.sd, discrepancy.time_s))
            flat.append(own[:, w].reshape(4, 40)[:, keep])
            forms.append(known.forms[:, w].reshape(2, 40)[:, keep])
    x, b = np.concatenate(flat, axis=1), np.concatenate(forms, axis=1)
    covariance = block_diag(*blocks) + b.T @ np.diag(np.square(scales)) @ b
    np.testing.assert_allclose(made.inner, x @ np.linalg.solve(covariance, x.T), rtol=1e-9, atol=1e-9)
    assert made.log_det == pytest.approx(np.linalg.slogdet(covariance)[1])


def test_a_drawn_share_of_friction_of_another_form_is_found_again() -> None:
    """Shares of 1, −1, 1 … drawn through known columns, white noise otherwise: their scale is about 1."""
    draw = np.random.default_rng(9)
    forms = 3.0 * draw.normal(size=(8, 30, 20, 1))
    left = draw.normal(size=(30, 20, 1)) + np.tensordot(np.tile([1.0, -1.0], 4), forms, 1)
    unknowns = Unknowns(np.zeros((0, 30, 20, 1)), forms)
    start = Discrepancy(np.array([1.0]), np.array([0.03]), 0.01)
    found = fitted_discrepancy([alone(left, unknowns)], [left], np.array([25.0]), start)
    assert found.sd[0] < 0.3
    assert 0.4 < found.share < 1.2  # the prior draws it towards 0


def test_a_contact_that_does_not_creep_is_found_beside_forms_that_nothing_draws() -> None:
    """A share of 0.5 of the last column, none of the eight others, which would show a thousandth."""
    draw = np.random.default_rng(9)
    forms = draw.normal(size=(9, 30, 20, 1)) * np.array([30.0] * 8 + [1.0])[:, None, None, None]
    left = draw.normal(size=(30, 20, 1)) + 0.5 * forms[8]
    unknowns = Unknowns(np.zeros((0, 30, 20, 1)), forms, 1)
    start = Discrepancy(np.array([1.0]), np.array([0.03]), 0.3)
    found = fitted_discrepancy([alone(left, unknowns)], [left], np.array([25.0]), start)
    assert found.share < 0.01
    assert 0.2 < found.contact < 0.8


def test_windows_with_a_discrepancy_of_their_own_size_against_dense_matrices() -> None:
    draw = np.random.default_rng(11)
    e, unknowns = log(draw)
    times = on_ladder(*np.exp(draw.normal(size=10))).reshape(5, 2)
    discrepancy = Discrepancy(on_ladder(0.8, 3.0), on_ladder(0.03, 0.006), 0.7, (times,))
    made = weighed([Whitening(e, replace(unknowns, forms=unknowns.forms[:0]))], [[np.zeros((1, 5, 20, 2))]], discrepancy)
    logs = 0.0
    for w in range(5):
        logs += np.linalg.slogdet(dense_of_window(e, unknowns, w, discrepancy.sd * times[w], discrepancy.time_s))[1]
    assert made.log_det == pytest.approx(logs)


def test_what_windows_say_one_by_one_against_dense_matrices() -> None:
    """Two logs, nothing shared: each window's ln p by itself. With shared forms that nothing speaks for it is the same."""
    draw = np.random.default_rng(17)
    logs, known = zip(*(log(draw) for _ in range(2)), strict=True)
    left = [np.where(np.isfinite(e.measured), draw.normal(size=e.measured.shape), 0.0) for e in logs]
    times = tuple(on_ladder(*np.exp(draw.normal(size=10))).reshape(5, 2) for _ in logs)
    discrepancy = Discrepancy(on_ladder(0.8, 3.0), on_ladder(0.03, 0.006), 1e-6, times)
    expected = []
    for e, unknowns, r, own in zip(logs, known, left, times, strict=True):
        for w in range(5):
            keep = np.isfinite(e.measured[w]).ravel()
            covariance = dense_of_window(e, unknowns, w, discrepancy.sd * own[w], discrepancy.time_s)
            of_window = multivariate_normal(np.zeros(len(covariance)), covariance)
            expected.append(of_window.logpdf(r[w].ravel()[keep]) + 0.5 * keep.sum() * np.log(2.0 * np.pi))
    np.testing.assert_allclose(
        by_window([Whitening(*own) for own in zip(logs, known, strict=True)], left, discrepancy), expected, atol=1e-6
    )


def test_a_window_that_is_far_off_is_told_from_the_others() -> None:
    """One of 40 windows is drawn with thirty times the discrepancy; δ stays that of the others."""
    draw = np.random.default_rng(13)
    roots = [np.linalg.cholesky(dense(np.ones(60, dtype=bool), sd, 0.03)) for sd in (1.0, 30.0)]
    left = np.stack([roots[w == 17] @ draw.normal(size=(60, 1)) for w in range(40)])
    none = Unknowns(np.zeros((0, 40, 60, 1)), np.zeros((0, 40, 60, 1)))
    start = Discrepancy(np.array([5.0]), np.array([0.03]), 0.3)
    found = fitted_discrepancy([alone(left, none)], [left], np.array([25.0]), start)
    assert found.sd[0] == pytest.approx(1.0, rel=0.25)
    assert found.times[0][17, 0] > 7.0
    assert np.median(found.times[0]) == pytest.approx(1.0, rel=0.2)
    other, log_p = on_other_logs([alone(left, none)], [left], np.array([25.0]), replace(found, times=()))
    assert other.times[0][17, 0] > 7.0
    plain = weighed([alone(left, none)], [[left[None]]], replace(found, times=()))
    assert log_p > 20.0 - 0.5 * (float(plain.inner[0, 0]) + plain.log_det)


@pytest.mark.parametrize(("sd", "time_s"), [(2.0, 0.02), (0.0, 0.03), (20.0, 0.05)])
def test_a_drawn_discrepancy_is_found_again(sd: float, time_s: float) -> None:
    """Residuals drawn with NumPy from the dense covariance; 60 windows of 60 samples know δ to a tenth."""
    draw = np.random.default_rng(7)
    root = np.linalg.cholesky(dense(np.ones(60, dtype=bool), sd, time_s))
    left = root @ draw.normal(size=(60, 60, 1))
    none = Unknowns(np.zeros((0, 60, 60, 1)), np.zeros((0, 60, 60, 1)))
    start = Discrepancy(np.array([5.0]), np.array([0.03]), 0.3)
    found = fitted_discrepancy([alone(left, none)], [left], np.array([25.0]), start)
    assert found.sd[0] == pytest.approx(sd, rel=0.15, abs=0.15)
    if sd > 1.0:
        assert found.time_s[0] == pytest.approx(time_s, rel=0.35)
