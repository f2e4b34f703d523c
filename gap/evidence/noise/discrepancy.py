"""How large the discrepancy is: δ and T of every channel and the share η where the log density of the residuals, with their priors, is
largest.

δ and η have half-normal priors (what honest models leave, gap.evidence.deciding_numbers), T a log-normal one. Channels meet only in what
they hang on together (unknowns): each adds its own inner products, so that a try of one channel costs one filter, a try of η none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import MEMORY_S, MEMORY_SPREAD, OTHER_FORM
from gap.evidence.noise.noise_model import Discrepancy, gram, reduced
from gap.evidence.noise.ornstein_uhlenbeck import filter_of, sample_period_s
from gap.evidence.noise.unknowns import Unknowns

_SMALLEST, _LARGEST = 0.02, 1e6  # of δ, in units of the noise: less changes nothing, more is a simulation that ran away
_LEAST_SHARE, _MOST_SHARE = 1e-3, 3.0
_STEPS = (np.log(3.0), np.log(1.5), np.log(1.15))  # of δ, T and η, on a logarithmic scale
_LEAPS = (0.1, 0.4, 1.6)
_SWEEPS = 4  # over the channels, at each step


@dataclass(frozen=True, slots=True)
class _Share:
    """What one channel adds: inner products of every log and window, and log|C|."""

    grams: tuple[Array, ...]
    log_det: float


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
    if not near:
        for c in range(len(scales)):
            search.leap(c)
    for step in _STEPS[1:] if near else _STEPS:
        for _ in range(_SWEEPS):
            gained = [search.improve(c, step) for c in search.moving] + [search.improve_share(step)]
            if not any(gained):
                break
    return search.found


def log_prior(discrepancy: Discrepancy, scales: Array) -> float:
    """ln p(δ) + ln p(ln T) + ln p(η), without constants that every model shares."""
    away = np.log(discrepancy.time_s / MEMORY_S) / MEMORY_SPREAD
    sizes = np.append(discrepancy.sd / scales, discrepancy.share / OTHER_FORM)
    return float(-0.5 * np.sum(sizes**2) - 0.5 * np.sum(away**2))


class _Search:
    def __init__(
        self, experiments: Sequence[Experiment], left: Sequence[Array], unknowns: Sequence[Unknowns], scales: Array, start: Discrepancy
    ) -> None:
        self._there = [np.isfinite(e.measured) for e in experiments]
        self._period_s = [sample_period_s(e) for e in experiments]
        self._rows = [np.concatenate([u.states, u.forms, r[None]]) for u, r in zip(unknowns, left, strict=True)]
        self._by_channel = [[np.ascontiguousarray(rows[..., c : c + 1]) for rows in self._rows] for c in range(len(scales))]
        self._sizes = [len(u.states) for u in unknowns], len(unknowns[0].forms)
        self._scales = scales
        self._longest_s = max(e.plan.rows * e.plan.period_s for e in experiments)
        self.moving = [c for c in range(len(scales)) if any(t[..., c].any() for t in self._there)]
        self.found = replace(start, sd=start.sd.copy(), time_s=start.time_s.copy())
        self._shares = [self._share(c, self.found.sd[c], self.found.time_s[c]) for c in range(len(scales))]
        self._total = [np.sum(parts, axis=0) for parts in zip(*(s.grams for s in self._shares), strict=True)]
        self._value = self._density(self._total, sum(s.log_det for s in self._shares), self.found)

    def leap(self, c: int) -> None:
        """To a typical T and some size: where δ is nearly nothing, or T as long as a window, small steps change nothing."""
        for sd in _LEAPS:
            self._try(c, sd, MEMORY_S)

    def improve(self, c: int, step: float) -> bool:
        """Whether a step of this channel's δ or T, or of both, either way, gave a larger density."""
        gained = False
        for change in (np.array([step, 0.0]), np.array([0.0, step]), np.array([step, 2.0 * step])):  # the last: δ² / T held
            for side in (1.0, -1.0):
                more_sd, more_time = np.exp(side * change)
                moved = self._try(c, self.found.sd[c] * more_sd, self.found.time_s[c] * more_time)
                gained = gained or moved
                if moved:
                    break
        return gained

    def improve_share(self, step: float) -> bool:
        """The same of η."""
        if not self._sizes[1]:
            return False
        log_dets = sum(s.log_det for s in self._shares)
        for side in (1.0, -1.0):
            share = float(np.clip(self.found.share * np.exp(side * step), _LEAST_SHARE, _MOST_SHARE))
            there = replace(self.found, share=share)
            value = self._density(self._total, log_dets, there)
            if value > self._value + 1e-3:
                self.found, self._value = there, value
                return True
        return False

    def _try(self, c: int, sd: float, time_s: float) -> bool:
        there = replace(self.found, sd=self.found.sd.copy(), time_s=self.found.time_s.copy())
        there.sd[c] = np.clip(sd, _SMALLEST, _LARGEST)
        there.time_s[c] = np.clip(time_s, min(self._period_s), self._longest_s)
        if there.sd[c] == self.found.sd[c] and there.time_s[c] == self.found.time_s[c]:
            return False
        old, new = self._shares[c], self._share(c, there.sd[c], there.time_s[c])
        total = [t - a + b for t, a, b in zip(self._total, old.grams, new.grams, strict=True)]
        value = self._density(total, sum(s.log_det for s in self._shares) - old.log_det + new.log_det, there)
        if not value > self._value + 1e-3:
            return False
        self.found, self._total, self._value, self._shares[c] = there, total, value, new
        return True

    def _share(self, c: int, sd: float, time_s: float) -> _Share:
        grams, log_det = [], 0.0
        for there, rows, period_s in zip(self._there, self._by_channel[c], self._period_s, strict=True):
            made = filter_of(there[:, :, c : c + 1], np.array([sd]), np.array([time_s]), period_s)
            grams.append(gram(made.by_window((rows,))))
            log_det += float(made.log_det.sum())
        return _Share(tuple(grams), log_det)

    def _density(self, total: Sequence[Array], log_dets: float, there: Discrepancy) -> float:
        found = reduced(total, *self._sizes, there.share)
        return -0.5 * (float(found.inner[0, 0]) + found.log_det + log_dets) + log_prior(there, self._scales)
