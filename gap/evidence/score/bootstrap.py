"""Shares of the posterior that do not rest on a few windows.

Logs are a few dozen windows, and a wrong set may gain all that it has in two of them, where a joint slipped otherwise than any model does.
So shares are not those of the sum over windows alone but their mean over its Bayesian bootstrap: windows weighted at random, the same
weights for all sets (Rubin 1981; Yao, Vehtari, Simpson and Gelman 2018, "pseudo-BMA+"). What all windows say alike stays sure.

And no window by itself makes a set negligible. With some probability it holds an event that no model foretells, a joint that lets go a
moment too early, and then a set that has it right had luck: p(window | set) is mixed with what the best of all sets says of that window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import logsumexp

from gap.data.measured import Array
from gap.evidence.deciding_numbers import NEGLIGIBLE

_DRAWS = 2000  # of the windows' weights


@dataclass(frozen=True, slots=True)
class Weight:
    """ln π(S) Z of a set, and ζ ln p of every window; what all sets share may be left out."""

    log_mass: float
    windows: Array


def bootstrapped(sets: Sequence[Weight]) -> list[float]:
    """The share of every set."""
    windows = np.stack([s.windows for s in sets])
    masses = np.array([s.log_mass for s in sets])
    limited = _limited(windows)
    masses = masses + np.sum(limited - windows, axis=1)
    logs = masses[:, None] + (limited - limited.mean(axis=0)) @ (random_weights(windows.shape[1]) - 1.0).T
    return [float(share) for share in np.exp(logs - logsumexp(logs, axis=0)).mean(axis=1)]


def _limited(windows: Array) -> Array:
    """Sets × windows, ln p: no window more than NEGLIGIBLE below what the best set there has."""
    lost = np.exp(NEGLIGIBLE)
    return np.asarray(np.logaddexp(windows + np.log1p(-lost), windows.max(axis=0) + NEGLIGIBLE))


@lru_cache(maxsize=4)
def random_weights(count: int) -> Array:
    """Draws × windows, or blocks of them; every draw sums to their number."""
    return np.asarray(count * np.random.default_rng(0).dirichlet(np.ones(count), _DRAWS))
