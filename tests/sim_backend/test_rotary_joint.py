"""The rotary joint against Eq 1 (corrected), Eq 4 and the reference's tables: linear theory, not the kernel, gives the numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_backend.kernel.kernel import hold_terms, start_air
from sim_backend.kernel.rates import rates
from sim_backend.memory.layout import DIFFERENTIAL, C, D, J
from sim_backend.memory.work import WORK
from sim_backend.plant import SimulatedRig
from tests.support.sim_backend.plants import (
    EQ4_DAMPING,
    EQ4_NUMERATOR,
    EQ4_STIFFNESS,
    SUPPLY_PA,
    eq4,
    isothermal,
    ornl,
    rotary_response,
    slot,
    unloaded_inertia_13,
)

DISPLACEMENT = 2260 / 13.79e6  # torque at supply pressure over supply pressure, as the paper rates the actuator


def test_ratings_at_2000_psi() -> None:
    """Row 1: 20 000 in lbf and 6283 lbf at 2000 psi."""
    p = SimulatedRig(ornl()).parameters.values
    torque = p[slot(0, J.AREA_A)] * p[C.SUPPLY_PRESSURE]
    force = p[slot(1, J.AREA_A)] * p[C.SUPPLY_PRESSURE]
    assert torque == pytest.approx(20_000 * 0.1129848290276167, rel=1e-3)
    assert force == pytest.approx(6283.19 * 4.4482216, rel=1e-3)
    assert p[slot(1, J.AREA_B)] / p[slot(1, J.AREA_A)] == pytest.approx(0.75, rel=1e-12)


def set_e() -> SimulatedRig:
    """Set E (docs/method/plant.md, P20): no Coulomb friction, no valve lag, a_l = 10/s, b = 130/s, J = 13; constants from linear theory."""
    sim = SimulatedRig(ornl(isothermal))
    p = sim.parameters.values
    inertia, volume, displacement = 13.0, 725e-6, p[slot(0, J.AREA_A)]
    leak, drag = 10.0, 130.0
    hydraulic = EQ4_STIFFNESS - leak * drag
    bulk = hydraulic * volume * inertia / (4 * displacement**2)
    conductance = leak * volume / (4 * bulk)
    flow_gain = math.radians(EQ4_NUMERATOR / EQ4_STIFFNESS) * displacement * (1 + leak * drag / hydraulic)  # m³/s per V
    p[C.ARM], p[C.BULK_MODULUS], p[C.BULK_PRESSURE_SLOPE] = 0.0, bulk, 0.0
    p[slot(0, J.MASS)], p[slot(0, J.VISCOUS)], p[slot(0, J.LAMINAR_PRESSURE)] = inertia, drag * inertia, 1.0
    for index in (J.COULOMB, J.STICTION, J.VALVE_TIME, J.HYSTERESIS, J.HOSE_COMPLIANCE, J.AIR_FRACTION, J.VISCOUS_OIL_SHARE):
        p[slot(0, index)] = 0.0
    coefficient, rounding = p[slot(0, J.FLOW_COEFFICIENT)], p[slot(0, J.ROUNDING)]
    null_conductance = coefficient * rounding / (4 * math.sqrt(SUPPLY_PA / 2))
    p[slot(0, J.CROSS_LEAKAGE)] = conductance - null_conductance
    p[slot(0, J.FULL_SCALE)] = coefficient * math.sqrt(SUPPLY_PA / 2) / flow_gain
    sim.reset()
    return sim


def test_linearised_set_e_is_eq_4() -> None:
    """Row 2: poles −70 ± 35.355j, gain 39.156 deg/s/V from central differences of the kernel's right-hand side."""
    sim = set_e()
    p, work, base = sim.parameters.values, np.zeros(WORK), sim.state.copy()
    hold_terms(base, p, work)
    states = [D.VELOCITY, D.PRESSURE_A, D.PRESSURE_B]
    steps = {D.VELOCITY: 1e-3, D.PRESSURE_A: 1e3, D.PRESSURE_B: 1e3, D.SPOOL: 1e-5}

    def derivative(index: D, sign: float) -> np.ndarray:
        x, d = base.copy(), np.zeros(DIFFERENTIAL)
        x[index] += sign * steps[index]
        start_air(x, p, work)
        rates(x, p, work, 0.0, 1e-6, d)
        return d[states]

    columns = {i: (derivative(i, 1.0) - derivative(i, -1.0)) / (2 * steps[i]) for i in (*states, D.SPOOL)}
    a, b = np.column_stack([columns[i] for i in states]), columns[D.SPOOL] / p[slot(0, J.FULL_SCALE)]
    poles = np.linalg.eigvals(a)
    pair = poles[np.argmax(poles.imag)]
    assert pair == pytest.approx(complex(-EQ4_DAMPING / 2, math.sqrt(EQ4_STIFFNESS - EQ4_DAMPING**2 / 4)), rel=1e-6)
    gain = -np.linalg.solve(a, b)[0]
    assert math.degrees(gain) == pytest.approx(EQ4_NUMERATOR / EQ4_STIFFNESS, rel=1e-6)
    assert math.degrees(gain) == pytest.approx(39.156, abs=5e-4)


def test_set_r_answers_like_eq_4_at_0_3_V() -> None:
    """Row 3: within 0.5 dB and 3 degrees from 0.5 to 8 Hz."""
    sim = SimulatedRig(ornl(unloaded_inertia_13, isothermal))
    for frequency in (0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0):
        ratio = rotary_response(sim, 0.3, frequency) / eq4(frequency)
        assert abs(20 * math.log10(abs(ratio))) < 0.5, frequency
        assert abs(math.degrees(np.angle(ratio))) < 3.0, frequency


@pytest.mark.parametrize(
    ("frequency_Hz", "gain_dB", "phase_deg"), [(0.5, 1.7, -1.0), (5.0, 5.0, 3.0), (8.0, 7.9, -16.0), (10.0, 8.3, -30.0), (15.0, 6.0, -52.0)]
)
def test_amplitude_sensitivity(frequency_Hz: float, gain_dB: float, phase_deg: float) -> None:
    """Row 11, the reference's table of 1 V relative to 0.1 V: 8.3 dB and 30 degrees at 10 Hz."""
    sim = SimulatedRig(ornl(unloaded_inertia_13, isothermal))
    ratio = rotary_response(sim, 1.0, frequency_Hz) / rotary_response(sim, 0.1, frequency_Hz)
    assert 20 * math.log10(abs(ratio)) == pytest.approx(gain_dB, abs=1.5)
    assert math.degrees(np.angle(ratio)) == pytest.approx(phase_deg, abs=8.0)


def test_gain_falls_as_the_oil_warms() -> None:
    """Row 9: gain at 0.1 V and 0.5 Hz at 22 and 56 degC relative to 40 degC: +17 % and −22 %."""
    sim = SimulatedRig(ornl(unloaded_inertia_13, isothermal))
    cold, middle, warm = (abs(rotary_response(sim, 0.1, 0.5, temperature_C=t)) for t in (22.0, 40.0, 56.0))
    assert 100 * (cold / middle - 1) == pytest.approx(17, abs=5)
    assert 100 * (warm / middle - 1) == pytest.approx(-22, abs=5)
