"""How much of the friction has another form than the model's, as the logs tell it.

The likeliest η says nothing where other forms change next to nothing: of a friction that hardly yields before it slides the logs cannot
tell which way it yields, and η is what was expected beforehand. So u is its mean over η's posterior.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap.data.measured import Array
from gap.evidence.deciding_numbers import OTHER_FORM
from gap.evidence.noise.discrepancy import LEAST_SHARE, MOST_SHARE, log_prior_of_share
from gap.evidence.noise.noise_model import Discrepancy, over_shares
from gap.evidence.noise.ornstein_uhlenbeck import at_rung, rung
from gap.evidence.noise.whitening import Whitening


def expected_form(logs: Sequence[Whitening], left: Sequence[Array], discrepancy: Discrepancy) -> float:
    """Mean of u = η² / (η² + OTHER_FORM²) for residuals `left`, beside a discrepancy whose η is not asked; 0 where nothing rubs."""
    if not logs[0].forms:
        return 0.0
    shares = at_rung(np.arange(int(rung(LEAST_SHARE)), int(rung(MOST_SHARE)) + 1))
    density = over_shares(logs, left, discrepancy, shares) + log_prior_of_share(shares)
    weights = shares * np.exp(density - density.max())  # of rungs, which lie as far apart as η is large
    return float(np.average(shares**2 / (shares**2 + OTHER_FORM**2), weights=weights))
