"""Whether one model predicts the hold-out better than another, judged window by window."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation, mean_cost, values_compared

BOUND = 3.0  # own standard deviations of a window beyond which it only says "much better": no single window decides
EVEN = 0.05  # of the mean excess: windows in which both models stay below it hold none of the gap and have no vote …
LARGE_GAP = 2.0  # … where the gap is larger than this many noise floors
EXACT = 1e-6  # noise floors: a quantised signal at rest is predicted exactly
LEAST_TELLING = 6  # windows that must be left, for others to be left out


def paired_t(before: Sequence[Evaluation], after: Sequence[Evaluation]) -> float:
    """t of the mean relative gain ln(before / after) per window; neighbouring windows may be correlated (W. Newey and
    K. West, Econometrica 55, 1987, with one lag).

    The logarithm, and bounded, because a gap shows in few windows with costs a thousand times those of the others; whether the sum of
    the costs falls is the gain's business. The yardstick is s, the standard deviation that pure noise gives the logarithm of a
    window's cost: gains are bounded by 3 s, windows whose gain is below s/3 say nothing about either model and are left out, and
    no window's gain is believed to be known better than within s. While the gap is large, windows that hold none of it are left out
    too: what a rest gains or loses near the noise floor must not outvote the motion.
    """
    most = max(mean_cost(before), mean_cost(after)) - 1.0
    level = 1.0 + EVEN * most if most > LARGE_GAP else 0.0
    voting = [np.maximum(a.window_costs, b.window_costs) > level for a, b in zip(before, after, strict=True)]
    if sum(int(v.sum()) for v in voting) < LEAST_TELLING:
        voting = [np.ones_like(v) for v in voting]
    ratios = [np.log((a.window_costs + EXACT) / (b.window_costs + EXACT)) / window_sd(a) for a, b in zip(before, after, strict=True)]
    gains = [np.clip(r[v], -BOUND, BOUND) for r, v in zip(ratios, voting, strict=True)]
    kept = np.abs(np.concatenate(gains)) > 1 / BOUND
    if kept.sum() >= LEAST_TELLING:
        gains = [g[np.abs(g) > 1 / BOUND] for g in gains]
    pooled = np.concatenate(gains)
    mean = float(pooled.mean())
    variance = float(np.mean((pooled - mean) ** 2))
    lagged = sum(float(np.sum((g[1:] - mean) * (g[:-1] - mean))) for g in gains) / len(pooled)
    return mean / float(np.sqrt((max(variance + lagged, 0.25 * variance) + 1.0) / len(pooled)))


def window_sd(evaluation: Evaluation) -> Array:
    """Standard deviation of ln(window cost) under pure noise: √(2/N), N the values compared in the window."""
    return np.asarray(np.sqrt(2.0 / values_compared(evaluation.experiment)))
