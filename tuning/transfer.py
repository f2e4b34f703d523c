"""Eq 4 of the paper and lag-lead compensators as transfer functions of python-control.

python-control loads matplotlib: what need not be a transfer function takes the numbers of Eq 4 from `tuning.eq4`.
"""

from __future__ import annotations

import control

from tuning.eq4 import NUMERATOR, PRODUCT_PER_S2, SUM_PER_S

EQ4 = control.tf([NUMERATOR], [1.0, SUM_PER_S, PRODUCT_PER_S2, 0.0])


def lag_lead(gain: float, sections: tuple[tuple[float, float], ...]) -> control.TransferFunction:
    """gain · Π (1 + s/zero)/(1 + s/pole), corners in rad/s as (zero, pole)."""
    result = control.tf([gain], [1.0])
    for zero, pole in sections:
        result = result * control.tf([1.0 / zero, 1.0], [1.0 / pole, 1.0])
    return result
