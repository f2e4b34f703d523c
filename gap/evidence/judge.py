"""The judge: how probable the hold-out is under a hypothesis fitted to other logs, with all that the fit left unsure.

Posterior predictive, linear about the fit: covariance Σ_h + J_h H⁻¹ J_hᵀ (MacKay 2003, ch. 28; Vehtari, Gelman and Gabry 2017). A constant
that the fit logs could not see, and which the hold-out's motion needs, is not held against the model. Held-out logs choose nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gap.data.windows import Experiment
from gap.evidence.hypothesis import Hypothesis, Seen, posterior
from gap.evidence.noise.noise_model import weighed
from gap.evidence.noise.unknowns import in_noise, linearised
from gap.fitting.sensitivity import sensitivities


def predictive(seen: Seen, hypothesis: Hypothesis, held: Sequence[Experiment], known: bool = False) -> float:
    """ln p(held | fitted logs), without constants that every hypothesis shares. `known`: nothing of the model is unsure."""
    at = hypothesis.at
    readings, unknowns = linearised(held, at.model.vector())
    left = Seen(tuple(held), seen.scales).left(readings)
    if known or not at.model.free:
        own = weighed(held, unknowns, [r[None] for r in left], at.discrepancy)
        return -0.5 * (float(own.inner[0, 0]) + own.log_det)
    covariance = np.linalg.inv(posterior(seen, at).precision)
    widths = np.clip(np.sqrt(np.diag(covariance)), 1e-3, 0.3)
    jacobian = [in_noise(e, j) for e, j in zip(held, sensitivities(at.model, held, range(len(widths)), readings, widths), strict=True)]
    rows = [np.concatenate([r[None], j]) for r, j in zip(left, jacobian, strict=True)]
    found = weighed(held, unknowns, rows, at.discrepancy)
    root = np.linalg.cholesky(covariance)
    unsure = root.T @ found.inner[1:, 1:] @ root + np.eye(len(root))
    explained = root.T @ found.inner[1:, 0]
    square = float(found.inner[0, 0] - explained @ np.linalg.solve(unsure, explained))
    return -0.5 * (square + found.log_det + float(np.linalg.slogdet(unsure)[1]))
