"""Slow heat: reservoir, supply hose, valve and actuator metal; what temperature does to oil and friction.

(P30) to (P34), (P9) and (P17) of docs/method/plant.md.
"""

from __future__ import annotations

from math import exp, log

from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import C, H, J, Vector
from sim_backend.memory.work import W

KELVIN = 273.15
_LN_10 = log(10.0)
REFERENCE_C = 40.0  # temperature at which coefficients are stated
NO_FLOW = 1e-9  # kg/s J/kg/K below which the oil takes the wall's temperature


@compiled
def viscosity_cSt(temperature_C: float, p: Vector) -> float:
    """Kinematic viscosity by Walther's law, (P34); ASTM D341."""
    return float(exp(_LN_10 * exp(_LN_10 * p[C.WALTHER_A] - p[C.WALTHER_B] * log(temperature_C + KELVIN))) - 0.7)


@compiled
def reference_viscosity(p: Vector) -> float:
    """Viscosity at the temperature where coefficients are stated; 0 without oil."""
    return viscosity_cSt(REFERENCE_C, p) if p[C.WALTHER_A] > 0.0 else 0.0


@compiled
def thinning(temperature_C: float, reference_cSt: float, p: Vector) -> float:
    """Viscosity at the reference temperature (reference_viscosity()) over that at this one; 1 without oil."""
    return reference_cSt / viscosity_cSt(temperature_C, p) if p[C.WALTHER_A] > 0.0 else 1.0


@compiled
def temperature_terms(temperature_C: float, thinner: float, p: Vector, j: int, w: Vector, k: int) -> None:
    """Write the coefficients of one slot at the present oil temperature into the work vector; `thinner`: thinning() there."""
    warmer = temperature_C - REFERENCE_C
    w[k + W.LIQUID] = p[C.BULK_MODULUS] * (1.0 + p[j + J.BULK_SLOPE] * warmer)
    w[k + W.HOSE] = p[j + J.HOSE_COMPLIANCE] / (1.0 + p[j + J.HOSE_SLOPE] * warmer)
    w[k + W.CROSS] = p[j + J.CROSS_LEAKAGE] * thinner
    w[k + W.EXTERNAL] = p[j + J.EXTERNAL_LEAKAGE] * thinner
    w[k + W.COULOMB] = p[j + J.COULOMB] * (1.0 + p[j + J.COULOMB_SLOPE] * warmer)
    share = p[j + J.VISCOUS_OIL_SHARE]
    w[k + W.VISCOUS] = p[j + J.VISCOUS] * (1.0 - share + share / thinner)
    w[k + W.VALVE_RATE] = 1.0 / p[j + J.VALVE_TIME]


@compiled
def _approach(wall: float, oil: float, conductance: float, flow_capacity: float) -> float:
    """Temperature of oil that has passed a wall: T_w + (T − T_w) exp(−UA/ṁc), as in (P30)."""
    if flow_capacity < NO_FLOW:
        return wall
    return wall + (oil - wall) * exp(-conductance / flow_capacity)


@compiled
def thermal_step(x: Vector, flow: float, supply_Pa: float, p: Vector, period_s: float) -> None:
    """Advance the three heat stores by one period with the mean valve flow (m³/s) of that period."""
    flow = max(flow, 0.0)
    capacity = p[C.DENSITY] * p[C.SPECIFIC_HEAT] * flow
    reservoir, hose, metal, room = x[H.RESERVOIR], x[H.HOSE], x[H.METAL], p[C.AMBIENT]
    line_end = _approach(hose, reservoir, p[C.HOSE_INSIDE], capacity)
    throttled = supply_Pa * flow
    into_metal = p[C.METAL_SHARE] * throttled
    inlet = line_end + ((throttled - into_metal) / capacity if capacity >= NO_FLOW else 0.0)
    outlet = _approach(metal, inlet, p[C.METAL_INSIDE], capacity)
    back = _approach(room, outlet, 0.5 * p[C.HOSE_OUTSIDE], capacity)
    bypass = p[C.BYPASS_SHARE] * supply_Pa * max(p[C.THERMAL_PUMP_FLOW] - flow, 0.0)
    to_reservoir = bypass + p[C.PUMP_LOSS] + capacity * (back - reservoir) - p[C.RESERVOIR_LOSS] * (reservoir - room)
    to_hose = capacity * (reservoir - line_end) - p[C.HOSE_OUTSIDE] * (hose - room)
    to_metal = into_metal + capacity * (inlet - outlet) - p[C.METAL_OUTSIDE] * (metal - room)
    x[H.RESERVOIR] += period_s * to_reservoir / p[C.RESERVOIR_CAPACITY]
    x[H.HOSE] += period_s * to_hose / p[C.HOSE_CAPACITY]
    x[H.METAL] += period_s * to_metal / p[C.METAL_CAPACITY]
    x[H.LINE_END], x[H.RETURN_OIL], x[H.OIL] = line_end, outlet, x[H.METAL]
