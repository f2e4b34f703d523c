"""What is believed of every free number before the logs are seen, in the fit's own coordinates φ (gap.evidence.score.coordinates).

A constant is normal about the rig file's value (log-normal where it is positive), with the standard deviation of its provenance. The size
of an effect, or a constant that is suspected of having changed, may be anything in its plausible range: normal about its neutral value
with the far end of the range RANGE_SDS standard deviations away, and nothing beyond its ends (half-normal where it has one sign).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.evidence.deciding_numbers import RANGE_SDS
from gap.evidence.score.coordinates import ends
from gap.evidence.score.laplace import log_share
from gap.fitting.model import Free, Model


@dataclass(frozen=True, slots=True)
class Prior:
    """Precision of every φ about 0, and where φ ends; `log_share`: ln of what of the normals of effects' sizes lies there. (Of a constant
    nearly all does, and all sets have it alike.)"""

    precision: Array
    low: Array
    high: Array
    log_share: float

    def log_density(self, phi: Array) -> float:
        """ln p(φ), without −½ ln 2π a number: what a Laplace approximation puts in again."""
        squares = float(np.sum(self.precision * phi**2))
        return 0.5 * (float(np.sum(np.log(self.precision))) - squares) - self.log_share


def prior_of(model: Model) -> Prior:
    """Of every free number of a model, in its order."""
    free, (low, high) = model.free, ends(model)
    precision = np.array([_precision(f) for f in free])
    sizes = [k for k, f in enumerate(free) if not f.prior]
    return Prior(precision, low, high, sum(log_share(low[k], high[k], precision[k]) for k in sizes))


def _precision(free: Free) -> float:
    if free.prior:
        return 1.0
    reach = max(free.high - free.start, free.start - free.low)
    return float((RANGE_SDS * free.scale / reach) ** 2)
