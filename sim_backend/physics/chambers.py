"""Oil in the chambers: compliance with temperature, pressure, air and hoses; cavitation ((P7) to (P9) of docs/method/plant.md)."""

from __future__ import annotations

from math import sqrt

import numpy as np

from config.schema.effect import Hook
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import C, J, Vector
from sim_backend.physics.laws import hooked, slot_of

ATMOSPHERE_PA = 101325.0
POLYTROPIC = 1.2  # exponent of the entrained air
_softened, _leaking = hooked(Hook.COMPLIANCE), hooked(Hook.LEAKAGE)
EXPANDED = 0.1  # relative pressure change within one step up to which the air's power law is expanded


@compiled
def air_share(absolute_Pa: float, fraction: float) -> float:
    """Volume share of entrained air, α₀ (P₀/P)^(1/1.2); x^(5/6) through square and cube root."""
    ratio = ATMOSPHERE_PA / absolute_Pa
    return float(fraction * sqrt(ratio) * np.cbrt(ratio))


@compiled
def hoses(per_Pa: float, gauge_Pa: float, p: Vector, j: int) -> float:
    """Relative volume change of hoses and structure per pressure, at a chamber pressure; `per_Pa`: the part that does not depend on it."""
    return _softened(per_Pa, (gauge_Pa,), slot_of(j), p)


@compiled
def cross_flow(conductance: float, a_Pa: float, b_Pa: float, p: Vector, j: int) -> float:
    """Leakage from chamber A to chamber B, m³/s; `conductance` is that of the laminar gap at temperature."""
    return _leaking(conductance * (a_Pa - b_Pa), (a_Pa, b_Pa), slot_of(j), p)


@compiled
def compliance(gauge_Pa: float, liquid_Pa: float, hose_per_Pa: float, p: Vector, j: int) -> float:
    """1/β_e at a chamber pressure. `liquid_Pa` is the liquid's modulus at no pressure, both it and the hose at temperature."""
    absolute = gauge_Pa + ATMOSPHERE_PA
    hose_per_Pa = hoses(hose_per_Pa, gauge_Pa, p, j)
    share = air_share(absolute, p[j + J.AIR_FRACTION])
    return float((1.0 - share) / (liquid_Pa + p[C.BULK_PRESSURE_SLOPE] * gauge_Pa) + share / (POLYTROPIC * absolute) + hose_per_Pa)


@compiled
def stiffness(
    volume: float, gauge_Pa: float, share_0: float, inverse_0: float, liquid_Pa: float, hose_per_Pa: float, slope: float
) -> float:
    """β_e / V, the pressure rise per inflow: the same law as compliance() with one division and no root.

    The air share is expanded about the absolute pressure 1/inverse_0 at the step's start, where it was share_0:
    x_g/P ∝ (1 + δ)^(−11/6). The remainder is below 5e-4 of the air's part for |δ| < 0.1; further off the share is computed anew.
    """
    liquid = liquid_Pa + slope * gauge_Pa
    if share_0 == 0.0:
        return liquid / (volume * (1.0 + hose_per_Pa * liquid))
    shift = (gauge_Pa + ATMOSPHERE_PA) * inverse_0 - 1.0
    if abs(shift) < EXPANDED:
        share = share_0 * (1.0 + shift * (-5.0 / 6.0 + shift * (55.0 / 72.0)))
        air = share_0 * inverse_0 / POLYTROPIC * (1.0 + shift * (-11.0 / 6.0 + shift * (187.0 / 72.0 - shift * (4301.0 / 1296.0))))
    else:
        ratio = 1.0 / (1.0 + shift)
        share = share_0 * sqrt(ratio) * np.cbrt(ratio)
        air = share * inverse_0 * ratio / POLYTROPIC
    return liquid / (volume * (1.0 - share + (hose_per_Pa + air) * liquid))


@compiled
def oil_pressure(state_Pa: float, vapour_Pa: float) -> float:
    """Gauge pressure of the oil for a pressure state. Below the vapour pressure the state counts the vapour's volume instead:
    it goes on falling with the oil that is missing and comes back by the same amount, so no oil is lost or made."""
    return max(state_Pa, vapour_Pa)


@compiled
def step_smoothing(opening: float, pressure_rise: float, p: Vector, j: int, step_s: float) -> float:
    """δ² of a land. The laminar range grows where the chamber would fill faster than the step can follow: at large openings
    into a small chamber next to its supply or return pressure. Vanishes with the step."""
    laminar = p[j + J.LAMINAR_PRESSURE]
    limit = 0.5 * step_s * p[j + J.FLOW_COEFFICIENT] * opening * pressure_rise
    limit *= limit
    return float(max(laminar * laminar, limit * limit))
