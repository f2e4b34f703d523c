"""What is known beforehand of the discrepancy: δ and T of every channel, the times s of every window, and the share η.

δ has a half-Cauchy prior of the scale that honest models leave (gap.evidence.deciding_numbers), η a half-normal, T and s log-normal ones.
The Cauchy's tail is long because no prior must decide where much is left: a half-normal's would pay 38 of ln p for a δ of 18 scales
instead of 20, whatever the logs say (Gelman 2006, "Prior distributions for variance parameters in hierarchical models").
"""

from __future__ import annotations

import numpy as np

from gap.data.measured import Array
from gap.evidence.deciding_numbers import MEMORY_S, OTHER_FORM, SPREAD
from gap.evidence.noise.noise_model import Discrepancy

LEAST_SHARE, MOST_SHARE = 1e-3, 3.0  # of η: less changes nothing, more is no friction


def expected(scales: Array, share: float, contact: float = 0.0) -> Discrepancy:
    """That of an honest model, alike in all windows, of channels with these scales of δ, a share η and one of contacts."""
    return Discrepancy(scales.copy(), np.full(len(scales), MEMORY_S), share, contact=contact)


def log_prior_of_share(share: Array | float) -> Array:
    """ln p(η), without constants that every model shares."""
    return np.asarray(-0.5 * (share / OTHER_FORM) ** 2)


def log_prior_of_sizes(discrepancy: Discrepancy, scales: Array) -> float:
    """ln p(δ) + ln p(ln T) + ln p(η), and of contacts, without constants that every model shares."""
    away = np.log(discrepancy.time_s / MEMORY_S) / SPREAD
    share = float(log_prior_of_share(discrepancy.share) + log_prior_of_share(discrepancy.contact))
    return float(-np.sum(np.log1p((discrepancy.sd / scales) ** 2)) + share - 0.5 * np.sum(away**2))


def log_prior_of_times(discrepancy: Discrepancy) -> Array:
    """ln p(ln s) of every window, one log after the other; 0 where all windows have the same δ."""
    if not discrepancy.times:
        return np.zeros(1)
    return np.concatenate([-0.5 * np.sum(np.log(times) ** 2, axis=1) for times in discrepancy.times]) / SPREAD**2
