"""Σ: what a right model may still be off by. White noise, one slow discrepancy a channel, every window's unknown start, and friction of
another form.

In units of the noise, with C from the discrepancy (ornstein_uhlenbeck), A what a window's own unknowns change and B what those do that all
windows share (unknowns), Σ = C + A Aᵀ + η² B Bᵀ. How wrong a right model is differs from window to window: where a joint sticks or slips a
moment too early, all that follows is off. So C has δ s, with s a window's own number. Nothing is inverted: inner products of rows whitened
by C, window by window,

    G = [A B x]ᵀ C⁻¹ [A B x]        xᵀ Σ⁻¹ x = G_xx less what A (window by window), then B (all together) take of it

are all that evidence, steps and screening need; log|Σ| = log|C| + Σ log|1 + G_AA| + log|1 + η² G_BB·A|.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.noise.ornstein_uhlenbeck import Filter, filter_of, sample_period_s
from gap.evidence.noise.unknowns import Unknowns


@dataclass(frozen=True, slots=True)
class Discrepancy:
    """What a right model leaves, one number a channel: `sd` δ in units of the channel's noise, `time_s` its correlation time T.
    `share` η: standard deviation of the shares of friction that have another form. `times` s: how many times δ a window has, one array a
    log, windows × channels; none stands for 1 everywhere."""

    sd: Array
    time_s: Array
    share: float
    times: tuple[Array, ...] = ()

    def of_log(self, number: int) -> Array:
        """Standard deviations of a log's windows: windows × channels, or one a channel."""
        return self.sd * self.times[number] if self.times else self.sd


@dataclass(frozen=True, slots=True)
class Weighed:
    """`inner`: xᵀ Σ⁻¹ x of rows x over all windows and logs; `log_det`: log|Σ|."""

    inner: Array
    log_det: float


def weighed(experiments: Sequence[Experiment], unknowns: Sequence[Unknowns], rows: Sequence[Array], discrepancy: Discrepancy) -> Weighed:
    """`rows`: of every log, rows × windows × samples × channels in units of the noise, 0 where nothing was measured."""
    grams, log_dets = _of_logs(experiments, unknowns, rows, discrepancy)
    found = reduced(grams, [len(u.states) for u in unknowns], len(unknowns[0].forms), discrepancy.share)
    return Weighed(found.inner, found.log_det + sum(float(d.sum()) for d in log_dets))


def by_window(experiments: Sequence[Experiment], unknowns: Sequence[Unknowns], left: Sequence[Array], discrepancy: Discrepancy) -> Array:
    """ln p of the residuals `left` in every window, one log after the other, with the likeliest shares of other friction; without the
    −½ ln 2π of the readings."""
    grams, log_dets = _of_logs(experiments, unknowns, [own[None] for own in left], discrepancy)
    states, forms = [len(u.states) for u in unknowns], len(unknowns[0].forms)
    rest = np.append(-likeliest_shares(grams, states, forms, discrepancy.share), 1.0)
    return np.concatenate([window_densities(g, n, rest) - 0.5 * d.sum(axis=1) for g, n, d in zip(grams, states, log_dets, strict=True)])


def _of_logs(
    experiments: Sequence[Experiment], unknowns: Sequence[Unknowns], rows: Sequence[Array], discrepancy: Discrepancy
) -> tuple[list[Array], list[Array]]:
    """Of every log the inner products [A B x]ᵀ C⁻¹ [A B x] of its windows, and log|C|, windows × channels."""
    grams, log_dets = [], []
    for n, (e, known, own) in enumerate(zip(experiments, unknowns, rows, strict=True)):
        made = filter_of(np.isfinite(e.measured), discrepancy.of_log(n), discrepancy.time_s, sample_period_s(e))
        grams.append(side_by_side(made, (known.states, known.forms, own), e.workers))
        log_dets.append(made.log_det)
    return grams, log_dets


def likeliest_shares(grams: Sequence[Array], states: Sequence[int], forms: int, share: float) -> Array:
    """The shares of other friction that the residuals, the last rows, would have most probably; of the scale η `share`."""
    inner = reduced(grams, states, 0, share).inner
    precision = inner[:forms, :forms] + np.eye(forms) / share**2
    return np.asarray(np.linalg.solve(precision, inner[:forms, forms]))


def window_densities(grams: Array, states: int, rest: Array) -> Array:
    """ln p of every window's residual, its own start marginalised, without −½ log|C|; `rest`: what of the other rows, the residual last, is
    left."""
    root = np.linalg.cholesky(grams[:, :states, :states] + np.eye(states))
    taken = np.linalg.solve(root, (grams[:, :states, states:] @ rest)[..., None])[..., 0]
    squares = np.einsum("i,wij,j->w", rest, grams[:, states:, states:], rest) - np.sum(taken**2, axis=1)
    return np.asarray(-0.5 * squares - np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1))


def side_by_side(made: Filter, rows: Sequence[Array], workers: int) -> Array:
    """Inner products of the whitened rows of every window, a share of the windows on every thread."""
    cuts = np.linspace(0, len(made.gain), max(workers, 1) + 1).astype(int)
    with ThreadPoolExecutor(max(workers, 1)) as pool:
        parts = pool.map(lambda ends: _of_windows(made, rows, slice(*ends)), pairwise(cuts))
    return np.concatenate(list(parts))


def _of_windows(made: Filter, rows: Sequence[Array], part: slice) -> Array:
    return gram(made.of_windows(part).by_window([r[:, part] for r in rows]))


def gram(white: Array) -> Array:
    """Inner products of the rows of every window: windows × rows × values → windows × rows × rows."""
    return np.asarray(np.matmul(white, white.transpose(0, 2, 1)))


def reduced(grams: Sequence[Array], states: Sequence[int], forms: int, share: float) -> Weighed:
    """Of rows that begin with `states` of a window's own and then `forms` shared ones: the others without what these take of them."""
    width = grams[0].shape[1] - states[0]
    total, log_det = np.zeros((width, width)), 0.0
    for whole, n in zip(grams, states, strict=True):
        log_det += _less_own(whole, n, total)
    if not forms:
        return Weighed(total, log_det)
    root = np.linalg.cholesky(share**2 * total[:forms, :forms] + np.eye(forms))
    taken = np.linalg.solve(root, share * total[:forms, forms:])
    return Weighed(total[forms:, forms:] - taken.T @ taken, log_det + 2.0 * float(np.log(np.diag(root)).sum()))


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _less_own(grams: Array, states: int, total: Array) -> float:
    """Adds to `total` what every window's own states leave of its other rows; log|1 + AᵀC⁻¹A| of all windows. A Cholesky factorisation
    whose columns go on below: what stands there at its end is taken."""
    windows, numbers, _ = grams.shape
    log_det = 0.0
    for w in range(windows):
        rows = grams[w, :states].copy()
        for j in range(states):
            rows[j, j] += 1.0
        for j in range(states):
            root = np.sqrt(rows[j, j])
            log_det += 2.0 * np.log(root)
            for m in range(j, numbers):
                rows[j, m] /= root
            for i in range(j + 1, states):
                part = rows[j, i]
                for m in range(i, numbers):
                    rows[i, m] -= part * rows[j, m]
        taken = np.ascontiguousarray(rows[:, states:])
        total += grams[w, states:, states:] - np.dot(taken.T, taken)
    return log_det
