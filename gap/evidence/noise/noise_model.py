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
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.evidence.noise.whitening import Blocks, Part, Whitening


@dataclass(frozen=True, slots=True)
class Discrepancy:
    """What a right model leaves, one number a channel: `sd` δ in units of the channel's noise, `time_s` its correlation time T.
    `share` η: standard deviation of the shares of friction that have another form. `times` s: how many times δ a window has, one array a
    log, windows × channels; none stands for 1 everywhere. `contact`: as η, of contacts that do not creep; 0 where there are none."""

    sd: Array
    time_s: Array
    share: float
    times: tuple[Array, ...] = ()
    contact: float = 0.0

    def of_log(self, number: int) -> Array:
        """Standard deviations of a log's windows: windows × channels, or one a channel."""
        return self.sd * self.times[number] if self.times else self.sd


@dataclass(frozen=True, slots=True)
class Weighed:
    """`inner`: xᵀ Σ⁻¹ x of rows x over all windows and logs; `log_det`: log|Σ|."""

    inner: Array
    log_det: float


def weighed(logs: Sequence[Whitening], rows: Sequence[Blocks], discrepancy: Discrepancy) -> Weighed:
    """`rows`: of every log, in units of the noise, 0 where nothing was measured."""
    grams, log_dets = _of_logs(logs, rows, discrepancy)
    found = reduced(grams, [log.states for log in logs], logs[0].widths(discrepancy.share, discrepancy.contact))
    return Weighed(found.inner, found.log_det + sum(float(d.sum()) for d in log_dets))


def by_window(logs: Sequence[Whitening], left: Sequence[Array], discrepancy: Discrepancy) -> Array:
    """ln p of the residuals `left` in every window, one log after the other, with the likeliest shares of other friction; without the
    −½ ln 2π of the readings."""
    grams, log_dets = _of_logs(logs, [(own[None],) for own in left], discrepancy)
    rest = np.append(-likeliest_shares(grams, [log.states for log in logs], logs[0].widths(discrepancy.share, discrepancy.contact)), 1.0)
    densities = [window_densities(g, log.states, rest) for g, log in zip(grams, logs, strict=True)]
    return np.concatenate([p - 0.5 * d.sum(axis=1) for p, d in zip(densities, log_dets, strict=True)])


def over_shares(logs: Sequence[Whitening], left: Sequence[Array], discrepancy: Discrepancy, shares: Array) -> Array:
    """ln p of the residuals `left` for every one of some `shares` η, δ, T and s as they are, up to what all have alike."""
    grams, _ = _of_logs(logs, [(own[None],) for own in left], discrepancy)
    total = _less_states_of_logs(grams, [log.states for log in logs])
    found = [less_shared(total, logs[0].widths(float(share), discrepancy.contact)) for share in shares]
    return np.array([-0.5 * (float(f.inner[0, 0]) + f.log_det) for f in found])


def _of_logs(logs: Sequence[Whitening], rows: Sequence[Blocks], discrepancy: Discrepancy) -> tuple[list[Array], list[Array]]:
    """Of every log the inner products [A B x]ᵀ C⁻¹ [A B x] of its windows, and log|C|, windows × channels."""
    found = [log.grams(own, discrepancy.of_log(n), discrepancy.time_s) for n, (log, own) in enumerate(zip(logs, rows, strict=True))]
    return [grams for grams, _ in found], [log_det for _, log_det in found]


def likeliest_shares(grams: Sequence[Array], states: Sequence[int], widths: Array) -> Array:
    """The shares of other friction that the residuals, the last rows, would have most probably; `widths`: their standard deviations."""
    forms, inner = len(widths), _less_states_of_logs(grams, states).inner
    precision = inner[:forms, :forms] + np.diag(1.0 / widths**2)
    return np.asarray(np.linalg.solve(precision, inner[:forms, forms]))


def window_densities(grams: Array, states: int, rest: Array) -> Array:
    """ln p of every window's residual, its own start marginalised, without −½ log|C|; `rest`: what of the other rows, the residual last, is
    left."""
    root = np.linalg.cholesky(grams[:, :states, :states] + np.eye(states))
    taken = np.linalg.solve(root, (grams[:, :states, states:] @ rest)[..., None])[..., 0]
    squares = np.einsum("i,wij,j->w", rest, grams[:, states:, states:], rest) - np.sum(taken**2, axis=1)
    return np.asarray(-0.5 * squares - np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1))


def reduced(grams: Sequence[Array], states: Sequence[int], widths: Array) -> Weighed:
    """Of rows that begin with `states` of a window's own and then shared ones, as many as `widths`: the others without what these take of
    them."""
    return less_shared(_less_states_of_logs(grams, states), widths)


def _less_states_of_logs(grams: Sequence[Array], states: Sequence[int]) -> Weighed:
    """What every window's own states leave, over all logs."""
    of_logs = [less_states_with(whole, None, n) for whole, n in zip(grams, states, strict=True)]
    return Weighed(np.sum([w.inner for w in of_logs], axis=0), sum(w.log_det for w in of_logs))


def less_states_with(grams: Array, part: Part | None, states: int) -> Weighed:
    """What every window's own states leave of its other rows, over all windows, and log|1 + AᵀC⁻¹A|; `part`: of one channel, whose inner
    products are to be added, x the last row."""
    upper = np.zeros((grams.shape[1] - states,) * 2)
    if part is None:
        log_det = _less_states(grams, states, upper)
    else:
        log_det = _less_states_of_sum(grams, part.grams, part.numbers, part.cross, states, upper)
    return Weighed(upper + np.triu(upper, 1).T, log_det)


def less_shared(total: Weighed, widths: Array) -> Weighed:
    """Without what the shared rows, the first ones, take of the others; `widths`: standard deviations of their shares."""
    forms = len(widths)
    if not forms:
        return total
    root = np.linalg.cholesky(np.outer(widths, widths) * total.inner[:forms, :forms] + np.eye(forms))
    taken = np.linalg.solve(root, widths[:, None] * total.inner[:forms, forms:])
    log_det = total.log_det + 2.0 * float(np.log(np.diag(root)).sum())
    return Weighed(total.inner[forms:, forms:] - taken.T @ taken, log_det)


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _less_states(grams: Array, states: int, total: Array) -> float:
    log_det = 0.0
    for w in range(len(grams)):
        log_det += _of_window(grams[w].copy(), states, total)
    return log_det


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _less_states_of_sum(grams: Array, added: Array, numbers: NDArray[np.int64], cross: Array, states: int, total: Array) -> float:
    log_det, last = 0.0, grams.shape[1] - 1
    whole = np.empty(grams.shape[1:])
    for w in range(len(grams)):
        own = added[numbers[w]]
        for i in range(last):
            for m in range(i, last):
                whole[i, m] = grams[w, i, m] + own[i, m]
            whole[i, last] = grams[w, i, last] + cross[w, i]
        whole[last, last] = grams[w, last, last] + cross[w, last]
        log_det += _of_window(whole, states, total)
    return log_det


@njit(cache=True, nogil=True)  # type: ignore[untyped-decorator]
def _of_window(rows: Array, states: int, total: Array) -> float:
    """Adds to the upper triangle of `total` what a window's states leave of the rows below them, eliminated in place; log|1 + AᵀC⁻¹A|. Each
    row takes the rows above it four at a time: half the time of one, the same bits."""
    numbers, log_det = len(rows), 0.0
    for j in range(states):
        rows[j, j] += 1.0
    for i in range(numbers):
        above, j = min(i, states), 0
        while j + 3 < above:
            a, b = rows[j, i] / rows[j, j], rows[j + 1, i] / rows[j + 1, j + 1]
            c, d = rows[j + 2, i] / rows[j + 2, j + 2], rows[j + 3, i] / rows[j + 3, j + 3]
            for m in range(i, numbers):
                rows[i, m] = (((rows[i, m] - a * rows[j, m]) - b * rows[j + 1, m]) - c * rows[j + 2, m]) - d * rows[j + 3, m]
            j += 4
        while j < above:
            part = rows[j, i] / rows[j, j]
            for m in range(i, numbers):
                rows[i, m] -= part * rows[j, m]
            j += 1
        if i < states:
            log_det += np.log(rows[i, i])
    for i in range(states, numbers):
        for m in range(i, numbers):
            total[i - states, m - states] += rows[i, m]
    return log_det
