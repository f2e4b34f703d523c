"""What is believed of every free number before the logs are seen, in the fit's own coordinates φ (gap.evidence.score.coordinates).

A constant is normal about the rig file's value (log-normal where it is positive), with the standard deviation of its provenance. The size
of an effect, or a constant that is suspected of having changed, may be anything in its plausible range: normal about its neutral value
(half-normal where it has one sign) with the far end of the range RANGE_SDS standard deviations away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.evidence.deciding_numbers import RANGE_SDS
from gap.evidence.score.coordinates import ends
from gap.fitting.model import Free, Model


@dataclass(frozen=True, slots=True)
class Prior:
    """Precision of every φ about 0, and where φ ends; `one_sided`: how many halves of normals among them."""

    precision: Array
    low: Array
    high: Array
    one_sided: int

    def log_density(self, phi: Array) -> float:
        """ln p(φ), without −½ ln 2π a number: what a Laplace approximation puts in again."""
        squares = float(np.sum(self.precision * phi**2))
        return 0.5 * (float(np.sum(np.log(self.precision))) - squares) + self.one_sided * float(np.log(2.0))


def prior_of(model: Model) -> Prior:
    """Of every free number of a model, in its order."""
    free, (low, high) = model.free, ends(model)
    halves = sum(not f.prior and f.start in (f.low, f.high) for f in free)
    return Prior(np.array([_precision(f) for f in free]), low, high, halves)


def _precision(free: Free) -> float:
    if free.prior:
        return 1.0
    reach = max(free.high - free.start, free.start - free.low)
    return float((RANGE_SDS * free.scale / reach) ** 2)
