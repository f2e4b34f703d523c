"""Set E: one set of oil, drag, leakage and valve for which corrected Eq 1 is exactly Eq 4, put into the running plant."""

from __future__ import annotations

from math import degrees, pi, sqrt

import control
import numpy as np

from config.schema.rig import Rig
from sim_backend.memory.layout import C, D, J
from sim_backend.plant import SimulatedRig
from tuning.eq4 import NUMERATOR, PRODUCT_PER_S2, SUM_PER_S
from tuning.linear.dry_friction import take_out_dry_friction
from tuning.linear.family import LEAK_PER_S
from tuning.linear.linear_arm import STATES, at_rest, jacobians
from tuning.variants import ROTARY

INERTIA_KG_M2 = 13.0
NOT_IN_SET_E = (J.VALVE_TIME, J.HYSTERESIS, J.HOSE_COMPLIANCE, J.AIR_FRACTION, J.VISCOUS_OIL_SHARE)


def set_e(rig: Rig) -> SimulatedRig:
    """The rotary joint alone with 13 kg·m²: ω_h² = 4850, a_l = 10, b = 130 1/s, velocity gain 49.65 °/s/V before leakage."""
    plant = SimulatedRig(rig)
    p, offset = plant.parameters.values, plant.parameters.offset
    viscous = SUM_PER_S - LEAK_PER_S
    stiffness = PRODUCT_PER_S2 - LEAK_PER_S * viscous
    displacement, supply = p[offset(J.AREA_A, ROTARY)], p[C.SUPPLY_PRESSURE]
    volume = p[offset(J.VOLUME_A, ROTARY)] + p[offset(J.VOLUME_B, ROTARY)]
    modulus = stiffness * volume * INERTIA_KG_M2 / (4.0 * displacement**2)
    conductance = LEAK_PER_S * volume / (4.0 * modulus)
    p[C.ARM], p[C.BULK_MODULUS], p[C.BULK_PRESSURE_SLOPE] = 0.0, modulus, 0.0
    p[offset(J.MASS, ROTARY)], p[offset(J.VISCOUS, ROTARY)] = INERTIA_KG_M2, viscous * INERTIA_KG_M2
    p[offset(J.LAMINAR_PRESSURE, ROTARY)] = 1.0
    take_out_dry_friction(plant.parameters, ROTARY)
    for index in NOT_IN_SET_E:
        p[offset(index, ROTARY)] = 0.0
    coefficient, rounding = p[offset(J.FLOW_COEFFICIENT, ROTARY)], p[offset(J.ROUNDING, ROTARY)]
    p[offset(J.CROSS_LEAKAGE, ROTARY)] = conductance - coefficient * rounding / (4.0 * sqrt(supply / 2.0))  # the null leaks the rest
    speed_per_volt = NUMERATOR / stiffness * pi / 180.0
    p[offset(J.FULL_SCALE, ROTARY)] = coefficient * sqrt(supply / 2.0) / (displacement * speed_per_volt)
    plant.reset()
    return plant


def poles_and_gain(plant: SimulatedRig) -> tuple[complex, float]:
    """Upper pole (1/s) and steady velocity per volt (°/s/V) of the joint, from differences of the plant's right-hand side."""
    values = plant.parameters.values.copy()
    values[C.STEP] = 1e-6  # without what the kernel smooths for its step
    matrix, _ = jacobians(at_rest(plant.state), values)
    rows = [STATES.index(state) for state in (D.VELOCITY, D.PRESSURE_A, D.PRESSURE_B)]
    a = matrix[np.ix_(rows, rows)]
    b = matrix[rows, STATES.index(D.SPOOL)] / values[plant.parameters.offset(J.FULL_SCALE, ROTARY)]
    joint = control.ss(a, b[:, None], [[1.0, 0.0, 0.0]], 0.0)
    poles = joint.poles()
    return complex(poles[np.argmax(poles.imag)]), degrees(float(joint.dcgain()))
