"""The judge: how probable the hold-out is under a hypothesis fitted to other logs, with all that the fit left unsure.

Posterior predictive, linear about the fit: covariance Σ_h + J_h H⁻¹ J_hᵀ (MacKay 2003, ch. 28; Vehtari, Gelman and Gabry 2017). A constant
that the fit logs could not see, and which the hold-out's motion needs, is not held against the model. Held-out logs choose nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.noise.discrepancy import on_other_logs
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.coordinates import phi_of, slopes
from gap.evidence.score.hypothesis import Hypothesis, Point, Seen, posterior
from gap.evidence.score.laplace import AT_END
from gap.evidence.score.prior import prior_of
from gap.fitting.simulate import simulate


def predictive(seen: Seen, hypothesis: Hypothesis, held: Seen, known: bool = False) -> Array:
    """ln p(held | fitted logs) without constants that every hypothesis shares: of every window, such that the sum is that of them all.
    `held`: the logs that judge, with what is integrated out there the same for every set. `known`: nothing of the model is unsure."""
    at, vector = hypothesis.at, hypothesis.model.vector()
    readings = tuple(simulate(e, [vector])[0] for e in held.experiments)
    shared = [at.discrepancy.share * u.forms for u in held.unknowns]
    if not known and at.model.free:
        shared = [np.concatenate(pair) for pair in zip(shared, _unsure(seen, at, held.experiments, readings), strict=True)]
    wide = [replace(u, forms=forms) for u, forms in zip(held.unknowns, shared, strict=True)]
    _, whole, windows = on_other_logs(held.experiments, held.left(readings), wide, held.scales, replace(at.discrepancy, share=1.0))
    return np.asarray(windows + (whole - windows.sum()) / len(windows))


def _unsure(seen: Seen, at: Point, held: Sequence[Experiment], readings: Sequence[Array]) -> list[Array]:
    """What the held readings change by, with what the fit left unsure, a standard deviation a column. A number that ended at the end of its
    range stays there: a normal on both sides of it would let an effect that is not there explain the hold-out."""
    prior, phi = prior_of(at.model), phi_of(at.model)
    free = np.flatnonzero((phi - prior.low > AT_END) & (prior.high - phi > AT_END))
    covariance = np.linalg.inv(posterior(seen, at).precision[np.ix_(free, free)])
    widths = np.clip(np.sqrt(np.diag(covariance)), 1e-3, 0.3)
    jacobian = slopes(at.model, held, [int(k) for k in free], readings, widths)
    root = np.linalg.cholesky(covariance)
    return [np.tensordot(root.T, in_noise(e, j), 1) for e, j in zip(held, jacobian, strict=True)]
