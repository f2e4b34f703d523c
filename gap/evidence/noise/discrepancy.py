"""How large the discrepancy is: δ and T of every channel, the times s of every window, and the share η, where the log density of the
residuals, with their priors, is largest.

δ has a half-Cauchy prior of the scale that honest models leave (gap.evidence.deciding_numbers), η a half-normal, T and s log-normal ones.
The Cauchy's tail is long because no prior must decide where much is left: a half-normal's would pay 38 of ln p for a δ of 18 scales
instead of 20, whatever the logs say (Gelman 2006, "Prior distributions for variance parameters in hierarchical models"). Channels meet only
in what they hang on together (unknowns): each adds its own inner products, so that a try of one channel costs one filter, a try of η none.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import MEMORY_S, OTHER_FORM, SPREAD
from gap.evidence.noise.noise_model import Discrepancy, likeliest_shares, reduced, window_densities
from gap.evidence.noise.ornstein_uhlenbeck import filter_of, sample_period_s
from gap.evidence.noise.unknowns import Unknowns

_SMALLEST, _LARGEST = 0.02, 1e6  # of δ, in units of the noise: less changes nothing, more is a simulation that ran away
_LEAST_SHARE, _MOST_SHARE = 1e-3, 3.0
_STEPS = (np.log(2.0), np.log(1.15))  # of δ, T and η, on a logarithmic scale; doubled as long as that helps
_GAIN = 0.01  # of ln p, below which a step is none
_LEAPS = (0.1, 0.4, 1.6)
_SWEEPS = 4  # over the channels, at each step
_TIMES = 2.0 ** np.arange(-3.0, 8.0)  # of δ in a window …
_NEAR = (0.5, 1.0, 2.0)  # … and of what it had, for a model close by


@dataclass(frozen=True, slots=True)
class _Part:
    """What one channel adds in one log: inner products of every window, and log|C| of each."""

    grams: Array
    log_det: Array


def fitted_discrepancy(
    experiments: Sequence[Experiment],
    left: Sequence[Array],
    unknowns: Sequence[Unknowns],
    scales: Array,
    start: Discrepancy,
    near: bool = False,
) -> Discrepancy:
    """For residuals `left` (windows × samples × channels of every log, in noise). `scales`: of δ's prior, one a channel. `near`: it was
    found for a model close by."""
    search = _Search(experiments, left, unknowns, scales, start)
    return (search.near() if near else search.whole()).found


def on_other_logs(
    experiments: Sequence[Experiment], left: Sequence[Array], unknowns: Sequence[Unknowns], scales: Array, start: Discrepancy
) -> tuple[Discrepancy, float]:
    """For logs that were not fitted, with η as it is: the likeliest δ, T and times there (what a model leaves depends on the motion), and
    ln p of the logs and of these."""
    search = _Search(experiments, left, unknowns, scales, replace(start, times=()), False).whole()
    return search.found, search.value


def log_prior(discrepancy: Discrepancy, scales: Array) -> float:
    """ln p(δ) + ln p(ln T) + ln p(ln s) + ln p(η), without constants that every model shares."""
    return log_prior_of_sizes(discrepancy, scales) + float(log_prior_of_times(discrepancy).sum())


def log_prior_of_sizes(discrepancy: Discrepancy, scales: Array) -> float:
    """ln p(δ) + ln p(ln T) + ln p(η)."""
    away = np.log(discrepancy.time_s / MEMORY_S) / SPREAD
    form = discrepancy.share / OTHER_FORM
    return float(-np.sum(np.log1p((discrepancy.sd / scales) ** 2)) - 0.5 * form**2 - 0.5 * np.sum(away**2))


def log_prior_of_times(discrepancy: Discrepancy) -> Array:
    """ln p(ln s) of every window, one log after the other; 0 where all windows have the same δ."""
    if not discrepancy.times:
        return np.zeros(1)
    return np.concatenate([-0.5 * np.sum(np.log(times) ** 2, axis=1) for times in discrepancy.times]) / SPREAD**2


class _Search:
    def __init__(
        self,
        experiments: Sequence[Experiment],
        left: Sequence[Array],
        unknowns: Sequence[Unknowns],
        scales: Array,
        start: Discrepancy,
        moves_share: bool = True,
    ) -> None:
        self._moves_share = moves_share
        self._workers = max(e.workers for e in experiments)
        self._there = [np.isfinite(e.measured) for e in experiments]
        self._period_s = [sample_period_s(e) for e in experiments]
        rows = [np.concatenate([u.states, u.forms, r[None]]) for u, r in zip(unknowns, left, strict=True)]
        self._by_channel = [[np.ascontiguousarray(np.moveaxis(own[..., c], 0, -1)) for own in rows] for c in range(len(scales))]
        self._sizes = [len(u.states) for u in unknowns], len(unknowns[0].forms)
        self._scales = scales
        self._longest_s = max(e.plan.rows * e.plan.period_s for e in experiments)
        self.moving = [c for c in range(len(scales)) if any(t[..., c].any() for t in self._there)]
        times = tuple(t.copy() for t in start.times) or tuple(np.ones((len(t), len(scales))) for t in self._there)
        self.found = replace(start, sd=start.sd.copy(), time_s=start.time_s.copy(), times=times)
        self._parts = [self._of_channel(c, self.found) for c in range(len(scales))]
        self._total = [np.sum([p.grams for p in parts], axis=0) for parts in zip(*self._parts, strict=True)]
        self.value = self._density(self._total, self.found)

    def whole(self) -> _Search:
        """From anywhere."""
        for c in self.moving:
            self.leap(c)
        for steps, near in ((_STEPS, False), (_STEPS[-1:], True)):
            self.settle(steps)
            for c in self.moving:
                self.weigh_windows(c, near)
        return self

    def near(self) -> _Search:
        """From what it was for a model close by."""
        self.settle(_STEPS)
        for c in self.moving:
            self.weigh_windows(c, True)
        return self

    def leap(self, c: int) -> None:
        """To a typical T and some size: where δ is nearly nothing, or T as long as a window, small steps change nothing."""
        for sd in _LEAPS:
            self._try(c, sd, MEMORY_S)

    def settle(self, steps: Sequence[float]) -> None:
        """δ and T of every channel, and η, until no step gains anything. Channels hardly touch each other: one that gained nothing is not
        asked again."""
        for step in steps:
            asked = self.moving
            for _ in range(_SWEEPS):
                asked = [c for c in asked if self.improve(c, step)]
                if not self.improve_share(step) and not asked:
                    break

    def improve(self, c: int, step: float) -> bool:
        """Whether a step of this channel's δ or T, or of both, either way, gave a larger density."""
        gained = False
        for change in (np.array([step, 0.0]), np.array([0.0, step]), np.array([step, 2.0 * step])):  # the last: δ² / T held
            gained = self._followed(c, change) or self._followed(c, -change) or gained
        return gained

    def _followed(self, c: int, change: Array) -> bool:
        """Whether a change of ln δ and ln T gained anything; it is doubled as long as it does."""
        gained = False
        while self._try(c, *(np.array([self.found.sd[c], self.found.time_s[c]]) * np.exp(change))):
            gained, change = True, 2.0 * change
        return gained

    def improve_share(self, step: float) -> bool:
        """The same of η."""
        if not self._sizes[1] or not self._moves_share:
            return False
        for side in (1.0, -1.0):
            share = float(np.clip(self.found.share * np.exp(side * step), _LEAST_SHARE, _MOST_SHARE))
            there = replace(self.found, share=share)
            value = self._density(self._total, there)
            if value > self.value + _GAIN:
                self.found, self.value = there, value
                return True
        return False

    def weigh_windows(self, c: int, near: bool = False) -> None:
        """Every window's own times of this channel's δ, beside the other channels and the likeliest shares of other friction."""
        now = self.found.times
        options = [tuple(np.clip(s * t, _TIMES[0], _TIMES[-1]) for t in now) for s in _NEAR] if near else _alike(now)
        with ThreadPoolExecutor(self._workers) as pool:
            tries = list(pool.map(lambda times: self._of_channel(c, replace(self.found, times=times)), options))
        rest = np.append(-likeliest_shares(self._total, *self._sizes, self.found.share), 1.0)
        found = [t.copy() for t in now]
        for n, (total, own) in enumerate(zip(self._total, self._parts[c], strict=True)):
            others = total - own.grams
            offered = np.stack([times[n][:, c] for times in options])
            values = np.stack([window_densities(others + one[n].grams, self._sizes[0][n], rest) - 0.5 * one[n].log_det for one in tries])
            values -= 0.5 * (np.log(offered) / SPREAD) ** 2
            found[n][:, c] = np.take_along_axis(offered, np.argmax(values, axis=0)[None], axis=0)[0]
        self._accept(c, self._about_one(c, found))

    def _about_one(self, c: int, times: Sequence[Array]) -> Discrepancy:
        """The same sizes with δ at the windows' geometric mean, where the prior of s wants it."""
        mean = float(np.mean(np.log(np.concatenate([t[:, c] for t in times]))))
        sd = self.found.sd.copy()
        sd[c] = np.clip(sd[c] * np.exp(mean), _SMALLEST, _LARGEST)
        for t in times:
            t[:, c] *= self.found.sd[c] / sd[c]
        return replace(self.found, sd=sd, times=tuple(times))

    def _try(self, c: int, sd: float, time_s: float) -> bool:
        there = replace(self.found, sd=self.found.sd.copy(), time_s=self.found.time_s.copy())
        there.sd[c] = np.clip(sd, _SMALLEST, _LARGEST)
        there.time_s[c] = np.clip(time_s, min(self._period_s), self._longest_s)
        if there.sd[c] == self.found.sd[c] and there.time_s[c] == self.found.time_s[c]:
            return False
        return self._accept(c, there)

    def _accept(self, c: int, there: Discrepancy) -> bool:
        """Whether a discrepancy that differs in one channel gives a larger density; then it is the one found."""
        old, new = self._parts[c], self._of_channel(c, there)
        total = [t - a.grams + b.grams for t, a, b in zip(self._total, old, new, strict=True)]
        self._parts[c] = new
        value = self._density(total, there)
        if not value > self.value + _GAIN:
            self._parts[c] = old
            return False
        self.found, self._total, self.value = there, total, value
        return True

    def _of_channel(self, c: int, there: Discrepancy) -> tuple[_Part, ...]:
        found = []
        for n, (measured, rows, period_s) in enumerate(zip(self._there, self._by_channel[c], self._period_s, strict=True)):
            made = filter_of(measured[:, :, c : c + 1], there.of_log(n)[:, c : c + 1], there.time_s[c : c + 1], period_s)
            white = made.side_by_side(rows)
            found.append(_Part(np.matmul(white.transpose(0, 2, 1), white), made.log_det[:, 0]))
        return tuple(found)

    def _density(self, total: Sequence[Array], there: Discrepancy) -> float:
        log_dets = sum(float(part.log_det.sum()) for parts in self._parts for part in parts)
        found = reduced(total, *self._sizes, there.share)
        return -0.5 * (float(found.inner[0, 0]) + found.log_det + log_dets) + log_prior(there, self._scales)


def _alike(now: Sequence[Array]) -> list[tuple[Array, ...]]:
    """All windows with the same times, as often as there are."""
    return [tuple(np.full_like(t, s) for t in now) for s in _TIMES]
