"""Valve, chambers, cylinder and supply against closed forms and conservation of oil."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import D_STRIDE, C, D, J, X
from sim_backend.memory.side_by_side import LANES, signed_roots
from sim_backend.physics.chambers import ATMOSPHERE_PA, compliance, stiffness
from sim_backend.physics.thermal import viscosity_cSt
from sim_backend.physics.valve import land_flow, openings
from tests.support.sim_backend.plants import (
    PSI_PA,
    SUPPLY_PA,
    Content,
    SimulatedRig,
    ideal,
    isothermal,
    ornl,
    quiet,
    slot,
    with_effects,
    without,
)

VAPOUR_GAUGE_PA = 1e4 - ATMOSPHERE_PA


def slow_cylinder(content: Content) -> None:
    """The cylinder alone matters: no friction, no leakage, rigid light link, rotary joint at rest."""
    ideal(content)
    isothermal(content)
    quiet(content)


def test_speeds_and_pressures_of_an_unequal_cylinder() -> None:
    """Row 27: v_ext/v_ret = 1/√r and chamber pressures (0.297, 0.396) extending, (0.527, 0.703) retracting, in shares of supply."""
    speeds, shares = [], []
    for volts in (5.0, -5.0):
        sim = SimulatedRig(ornl(slow_cylinder))
        sim.parameters.values[slot(1, J.ROUNDING)] = 1e-6
        sim.parameters.values[slot(1, J.VISCOUS)] = 1.0  # settles the undamped oil spring, 0.2 N at this speed
        sim.parameters.values[slot(1, J.CROSS_LEAKAGE)] = 0.0
        result = sim.run(np.tile([0.0, volts], (1200, 1)), 1e-3)
        late = slice(900, 1200)
        speeds.append(abs(result["prismatic.velocity"][late].mean()))
        shares.append([result[f"prismatic.pressure_{side}"][late].mean() / SUPPLY_PA for side in "ab"])
    r = 0.75
    assert speeds[0] / speeds[1] == pytest.approx(1 / math.sqrt(r), rel=5e-3)
    assert shares[0] == pytest.approx([r / (1 / r**2 + r), 1 / (1 / r**2 + r)], rel=5e-3)
    assert shares[1] == pytest.approx([r / (1 + r**3), 1 / (1 + r**3)], rel=5e-3)


@compiled
def roots_of_four(drops: tuple[float, ...], smoothing: tuple[float, ...]) -> tuple[float, ...]:
    return signed_roots(drops, smoothing)  # type: ignore[no-any-return]


def test_flows_side_by_side_have_the_bits_of_flows_one_by_one() -> None:
    random = np.random.default_rng(5)
    drops = np.concatenate([random.normal(0.0, 1e6, 400), [0.0, -0.0, 1e-300, -2e7, 1e200, -1e200, 5e-324, 1.0]])
    smoothing = 1.0 + np.abs(random.normal(0.0, 1e12, drops.size)) * random.integers(0, 2, drops.size)
    for first in range(0, drops.size, LANES):
        pair = [tuple(map(float, each[first : first + LANES])) for each in (drops, smoothing)]
        one_by_one = np.array([land_flow(drop, smooth) for drop, smooth in zip(*pair, strict=True)])
        assert np.array(roots_of_four(*pair)).tobytes() == one_by_one.tobytes()


def test_valve_flow_at_rating_and_null_leakage() -> None:
    """15 gpm at 1000 psi, 0.35 gpm null leakage at 2000 psi with the 15 gpm valve."""
    p = SimulatedRig(ornl()).parameters.values
    gpm = 6.30902e-5
    coefficient = p[slot(0, J.FLOW_COEFFICIENT)]
    assert coefficient * math.sqrt(500 * PSI_PA) == pytest.approx(15 * gpm, rel=1e-5)
    opened, closed = openings(0.0, p, slot(0, J.KIND))
    assert coefficient * (opened + closed) * math.sqrt(SUPPLY_PA / 2) == pytest.approx(0.350 * gpm, rel=5e-3)
    for spool in (-0.4, -0.01, 0.003, 0.8):
        opened, closed = openings(spool, p, slot(0, J.KIND))
        assert opened - closed == pytest.approx(spool, rel=1e-9)


@pytest.mark.parametrize(
    ("pressure_MPa", "temperature_C", "modulus_MPa"), [(0.5, 40, 253), (1, 20, 447), (2, 60, 485), (6.9, 40, 569), (13.8, 20, 619)]
)
def test_effective_bulk_modulus(pressure_MPa: float, temperature_C: float, modulus_MPa: float) -> None:
    """1/β_e by hand from (P8) and (P9) of docs/method/plant.md (pressures there are absolute)."""
    p = SimulatedRig(ornl()).parameters.values
    warmer, gauge = temperature_C - 40, pressure_MPa * 1e6 - ATMOSPHERE_PA
    liquid, hose = 3e9 * (1 - 0.0035 * warmer), 1 / (709e6 * (1 - 0.004 * warmer))
    assert 1e-6 / compliance(gauge, liquid, hose, p, slot(0, J.KIND)) == pytest.approx(modulus_MPa, rel=3e-3)


@pytest.mark.parametrize("shift", [-0.5, -0.099, -0.05, 0.0, 0.05, 0.099, 1.0])
def test_stiffness_is_the_compliance_within_a_step(shift: float) -> None:
    """The expansion used inside a step, about a pressure up to 10 % away, and the full law further off."""
    p, gauge, volume = SimulatedRig(ornl()).parameters.values, 0.4e6, 3e-4
    j = slot(0, J.KIND)
    start = (gauge + ATMOSPHERE_PA) / (1 + shift)
    share = p[j + J.AIR_FRACTION] * (ATMOSPHERE_PA / start) ** (5 / 6)
    law = compliance(gauge, 3e9, 1.41e-9, p, j)
    assert stiffness(volume, gauge, share, 1 / start, 3e9, 1.41e-9, 6.0) == pytest.approx(1 / (volume * law), rel=5e-4)


def test_viscosity_table() -> None:
    p = SimulatedRig(ornl()).parameters.values
    table = {10: 147, 20: 92.7, 30: 61.7, 40: 43.0, 50: 31.2, 60: 23.4}
    assert [viscosity_cSt(float(t), p) for t in table] == pytest.approx(list(table.values()), rel=6e-3)


def oil_in_chamber(pressure_state: float, volume: float, p: np.ndarray) -> float:
    """Oil content of a chamber as volume at 0 gauge: V (1 + ∫ compliance dP), below the vapour pressure with its compliance there."""
    j = slot(1, J.KIND)

    def law(pressure: float) -> float:
        return compliance(max(pressure, VAPOUR_GAUGE_PA), 3e9, p[j + J.HOSE_COMPLIANCE], p, j)

    compressed, _ = quad(law, 0.0, pressure_state, points=[VAPOUR_GAUGE_PA] if pressure_state < VAPOUR_GAUGE_PA else None, limit=200)
    return volume * math.exp(compressed)


@pytest.mark.parametrize("air", [0.0, 0.005])
def test_cavitation_keeps_the_oil_and_the_vapour_pressure(air: float) -> None:
    """A mass that runs away from closed lands tears the oil: pressure stops at vapour pressure, and all oil is there afterwards."""
    rig = ornl(slow_cylinder, with_effects({"effect": "entrained_air", "where": "prismatic", "fraction": air}))
    sim = SimulatedRig(rig)
    p, x = sim.parameters.values, sim.state
    p[slot(1, J.FLOW_COEFFICIENT)] = 0.0  # both lands shut: the chambers keep their oil
    x[D_STRIDE + D.PRESSURE_A] = x[D_STRIDE + D.PRESSURE_B] = 1e6
    x[D_STRIDE + D.VELOCITY] = 1.5

    def oil() -> list[float]:
        travel = x[D_STRIDE + D.POSITION] - p[slot(1, J.VOLUME_POSITION)]
        volumes = (
            p[slot(1, J.VOLUME_A)] + p[slot(1, J.AREA_A)] * travel,
            p[slot(1, J.VOLUME_B)] - p[slot(1, J.AREA_B)] * travel,
        )
        states = (x[D_STRIDE + D.PRESSURE_A], x[D_STRIDE + D.PRESSURE_B])
        return [oil_in_chamber(state, volume, p) for state, volume in zip(states, volumes, strict=True)]

    before, lowest, states = oil(), math.inf, []
    for _ in range(200):
        sim.advance([0.0, 0.0], 2.5e-4)
        lowest = min(lowest, sim.true_signal("prismatic.pressure_a"), sim.true_signal("prismatic.pressure_b"))
        states.append(min(x[D_STRIDE + D.PRESSURE_A], x[D_STRIDE + D.PRESSURE_B]))
    assert min(states) < VAPOUR_GAUGE_PA or air > 0, "the test must tear the oil"
    assert lowest >= VAPOUR_GAUGE_PA
    assert oil() == pytest.approx(before, rel=2e-3)


def test_oil_taken_from_the_supply_is_what_the_chambers_swept() -> None:
    """Leak-free valve lands and cylinder, one stroke: ∫ supply flow = area × stroke + compression, per direction."""
    sim = SimulatedRig(ornl(slow_cylinder))
    p = sim.parameters.values
    p[slot(1, J.ROUNDING)], p[slot(0, J.ROUNDING)], p[slot(1, J.VISCOUS)] = 1e-9, 1e-9, 2e3
    sim.reset()
    start, pressure = sim.true_position[1], sim.true_signal("prismatic.pressure_a")
    taken = sim.state[D_STRIDE + D.SUPPLY_VOLUME]
    for _ in range(1000):
        sim.advance([0.0, 4.0], 1e-3)
    swept = p[slot(1, J.AREA_A)] * (sim.true_position[1] - start)
    volume = p[slot(1, J.VOLUME_A)] + p[slot(1, J.AREA_A)] * (sim.true_position[1] - p[slot(1, J.VOLUME_POSITION)])
    compressed = volume * (sim.true_signal("prismatic.pressure_a") - pressure) / 3.03e9
    assert sim.state[D_STRIDE + D.SUPPLY_VOLUME] - taken == pytest.approx(swept + compressed, rel=2e-3)


DROOP = {
    "effect": "supply_droop",
    "where": "supply",
    "inverse_gas_volume": "433 1/m^3",
    "pump_flow": "0 gpm",
    "relief_pressure": "2200 psi",
}


def test_accumulator_follows_the_gas_law() -> None:
    """Pump off: the supply pressure falls along P V^1.4 with the oil taken."""
    sim = SimulatedRig(ornl(isothermal, with_effects(DROOP)))
    x = sim.state
    p0, v0, taken0 = x[X.SUPPLY_PRESSURE], x[X.GAS_RATIO] / 433, x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
    for _ in range(700):
        sim.advance([0.0, 6.0], 1e-3)
    taken = x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME] - taken0
    expected = p0 * (v0 / (v0 + taken)) ** 1.4
    assert x[X.SUPPLY_PRESSURE] == pytest.approx(expected, rel=1e-6)


def test_pump_refills_and_relief_opens() -> None:
    """With the pump on the pressure settles within its regulation band; above the relief pressure oil leaves."""
    sim = SimulatedRig(ornl(isothermal, with_effects(DROOP | {"pump_flow": "10 gpm"})))
    sim.run(np.tile([0.0, 6.0], (600, 1)), 1e-3)
    drooped = sim.true_signal("rotary.supply_pressure")
    sim.run(np.zeros((6000, 2)), 1e-3)
    assert SUPPLY_PA - 100 * PSI_PA < sim.true_signal("rotary.supply_pressure") < SUPPLY_PA
    assert drooped < 0.97 * SUPPLY_PA
    sim.state[X.SUPPLY_PRESSURE] = 2400 * PSI_PA
    sim.run(np.zeros((3000, 2)), 1e-3)
    assert sim.true_signal("rotary.supply_pressure") < 2205 * PSI_PA


def test_line_loss_and_back_pressure_follow_the_squared_flow() -> None:
    loss = {"effect": "line_loss", "where": "supply", "resistance": 2.5e11}
    back = {"effect": "return_back_pressure", "where": "supply", "pressure": "25 psi", "resistance": 1e11}
    sim = SimulatedRig(ornl(slow_cylinder, with_effects(loss, back)))
    sim.parameters.values[slot(1, J.VISCOUS)] = 2e3
    sim.run(np.tile([0.0, 5.0], (800, 1)), 1e-3)
    velocity, p = sim.state[D_STRIDE + D.VELOCITY], sim.parameters.values
    flow_in, flow_out = p[slot(1, J.AREA_A)] * velocity, p[slot(1, J.AREA_B)] * velocity
    drop, raised = p[C.SUPPLY_PRESSURE] - sim.true_signal("prismatic.supply_pressure"), sim.true_signal("prismatic.return_pressure")
    assert drop == pytest.approx(2.5e11 * flow_in**2, rel=1e-2)
    assert raised == pytest.approx(25 * PSI_PA + 1e11 * flow_out**2, rel=1e-2)


def test_shut_chambers_resonate_at_the_hydraulic_frequency() -> None:
    """Rotary joint with shut lands, no leak: ω_h² = 4 β D²/(V J) with the table's 569 MPa."""
    rig = ornl(isothermal, without("cross_leakage", "coulomb_friction", "stiction", "viscous_friction", "link_flexibility"))
    sim = SimulatedRig(rig)
    p = sim.parameters.values
    p[slot(0, J.FLOW_COEFFICIENT)], p[C.ARM], p[slot(0, J.MASS)] = 0.0, 0.0, 13.0
    sim.state[D.VELOCITY] = 0.01
    velocity = sim.run(np.zeros((4000, 2)), 2.5e-4)["rotary.velocity"]
    spectrum = np.abs(np.fft.rfft((velocity - velocity.mean()) * np.hanning(velocity.size), 1 << 16))
    frequency = np.argmax(spectrum) / (65536 * 2.5e-4)
    displacement, bulk = p[slot(0, J.AREA_A)], 569e6
    assert frequency == pytest.approx(math.sqrt(4 * bulk * displacement**2 / (725e-6 * 13.0)) / (2 * math.pi), rel=5e-3)
