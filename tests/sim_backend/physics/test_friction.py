"""LuGre friction, end stops, backlash: breakaway, passivity, contact without energy gain, by their own laws."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from gap.evidence.noise.repeated import element
from sim_backend.memory.layout import D_STRIDE, C, D, J
from sim_backend.physics.energy import mechanical_energy
from sim_backend.physics.friction import friction, stop_force
from tests.support.sim_backend.plants import Content, SimulatedRig, mechanics_only, ornl, set_motion, slot, variant, with_effects

STEP_S = 1e-4


def rotary_vector() -> tuple[np.ndarray, int]:
    return SimulatedRig(ornl()).parameters.values, slot(0, J.KIND)


def slide(p: np.ndarray, j: int, velocity: np.ndarray, step_s: float = STEP_S) -> tuple[np.ndarray, np.ndarray]:
    """Friction force and bristle deflection along a velocity history, held over each step (classical Runge-Kutta, as the kernel)."""
    bristle, forces, bristles = 0.0, np.empty(velocity.size), np.empty(velocity.size)
    for i, v in enumerate(velocity):
        forces[i], rate = friction(v, bristle, 0.0, 105.0, 1000.0, p, j, step_s)
        bristles[i] = bristle
        rate_2 = friction(v, bristle + 0.5 * step_s * rate, 0.0, 105.0, 1000.0, p, j, step_s)[1]
        rate_3 = friction(v, bristle + 0.5 * step_s * rate_2, 0.0, 105.0, 1000.0, p, j, step_s)[1]
        rate_4 = friction(v, bristle + step_s * rate_3, 0.0, 105.0, 1000.0, p, j, step_s)[1]
        bristle += step_s / 6 * (rate + 2 * rate_2 + 2 * rate_3 + rate_4)
    return forces, bristles


@pytest.mark.parametrize("velocity", [-2.0, -0.3, -0.01, 0.005, 0.02, 0.1, 0.8])
def test_steady_sliding_follows_the_stribeck_curve(velocity: float) -> None:
    p, j = rotary_vector()
    forces, _ = slide(p, j, np.full(20000, velocity))
    expected = math.copysign(105 + 31 * math.exp(-((velocity / 0.02) ** 2)), velocity) + 1000 * velocity
    assert forces[-1] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("elastic", [0.0, 0.8])
@pytest.mark.parametrize("seed", range(4))
def test_friction_is_passive(seed: float, elastic: float) -> None:
    """From an undeformed bristle, ∫ F v dt − ½ σ₀ z² never becomes negative, for any velocity history."""
    p, j = rotary_vector()
    p[j + J.BRISTLE_ELASTIC] = elastic
    random = np.random.default_rng(seed)
    t = np.arange(60000) * STEP_S
    velocity = sum(a * np.sin(2 * np.pi * f * t + s) for a, f, s in random.uniform([0.001, 0.2, 0], [0.3, 20, 6.3], (5, 3)))
    forces, bristles = slide(p, j, np.asarray(velocity))
    dissipated = np.cumsum(forces * velocity) * STEP_S - 0.5 * p[j + J.BRISTLE_STIFFNESS] * bristles**2
    assert dissipated.min() > -1e-4 * dissipated.max()
    assert dissipated[-1] > 0


def test_an_elastic_contact_nears_the_stop_operator() -> None:
    """Prandtl's element: force = level × what a stop of way level / σ₀ holds, over strokes with turns before and after it slips."""
    p, j = rotary_vector()
    p[j + J.STICTION] = p[j + J.BRISTLE_DAMPING] = 0.0
    p[j + J.BRISTLE_ELASTIC] = 0.98
    way = 105.0 / p[j + J.BRISTLE_STIFFNESS]
    turns = np.array([0.0, 3.0, 2.5, 2.9, 0.0, 0.5, -3.0]) * way
    path = np.concatenate([np.linspace(a, b, 4000, endpoint=False) for a, b in pairwise(turns)])
    velocity = np.diff(path) / STEP_S
    forces, _ = slide(p, j, velocity)
    np.testing.assert_allclose(forces - 1000.0 * velocity, 105.0 * element(path, way)[:-1], atol=0.03 * 105.0)


@pytest.mark.parametrize(("elastic", "least", "most"), [(0.0, 0.5, np.inf), (0.8, -1e-3, 1e-3)])
def test_only_an_elastic_contact_stays_under_a_small_vibrating_load(elastic: float, least: float, most: float) -> None:
    """Half the level with a vibration of a tenth of it upon it, followed quasi-statically by the bend: LuGre creeps on with every cycle."""
    p, j = rotary_vector()
    p[j + J.STICTION] = p[j + J.BRISTLE_DAMPING] = 0.0
    p[j + J.BRISTLE_ELASTIC] = elastic
    way, moved, bent, after_one = 105.0 / p[j + J.BRISTLE_STIFFNESS], 0.0, 0.0, 0.0
    wanted = way * np.concatenate([np.linspace(0, 0.5, 500), 0.5 + 0.1 * np.sin(np.linspace(0, 40 * np.pi, 20000))])
    for number, change in enumerate(np.diff(wanted)):
        velocity = math.copysign(1e-6, change)
        moved += change / (friction(velocity, bent, 0.0, 105.0, 0.0, p, j, STEP_S)[1] / velocity)
        bent += change
        after_one = moved if number == 1499 else after_one
    assert least <= (moved - after_one) / way <= most


def test_breakaway_torque() -> None:
    """A slowly growing torque moves the joint for good when it passes F_s = 136 N m, and only the bristles before."""
    sim = SimulatedRig(ornl())
    mechanics_only(sim)
    p = sim.parameters.values
    p[slot(0, J.COULOMB)], p[slot(0, J.STICTION)] = 105.0, 31.0
    p[C.BENDING_STIFFNESS] = 0.0
    sim.reset()
    torque = np.linspace(0.0, 160.0, 16000)
    result = sim.run(np.column_stack([torque, np.zeros_like(torque)]), 1e-3)
    broken = torque[np.argmax(result["rotary.velocity"] > 0.01)]
    assert broken == pytest.approx(136.0, rel=0.03)
    held = torque < 100
    # from rest z = g/σ₀ (1 − exp(−σ₀ x/g)) and F = σ₀ z: x = −(g/σ₀) ln(1 − F/g)
    moved = -136 / p[slot(0, J.BRISTLE_STIFFNESS)] * math.log(1 - 100 / 136)
    assert result["rotary.position"][held][-1] == pytest.approx(moved, rel=1e-2)


@pytest.mark.parametrize("elastic", [0.0, 0.8, 0.95])
def test_fast_sliding_stays_stable_with_a_coarse_step(elastic: float) -> None:
    """The bristles' relaxation is faster than a 1 ms step can follow at 5 rad/s: the force must still be the steady one. It is faster still
    where the last of them yield over a fifth or a twentieth of the way."""
    p, j = rotary_vector()
    p[j + J.BRISTLE_ELASTIC] = elastic
    forces, _ = slide(p, j, np.full(200, 5.0), step_s=1e-3)
    assert forces[-50:] == pytest.approx(np.full(50, 105 + 1000 * 5.0), rel=1e-6)


@pytest.mark.parametrize("speed", [0.05, 0.4, 2.0])
def test_end_stop_gives_back_less_than_it_took(speed: float) -> None:
    """The tube runs into its outer stop: it comes back slower, stays within the stop's give, and energy never grows."""
    sim = SimulatedRig(ornl())
    mechanics_only(sim)
    p = sim.parameters.values
    p[slot(1, J.HIGH)] = 1.524
    p[C.BENDING_STIFFNESS] = 0.0
    sim.reset()
    set_motion(sim, 1, 1.5, speed)
    velocities, energies, deepest = [], [], 0.0
    for _ in range(4000):
        sim.advance([0.0, 0.0], 2.5e-4)
        velocities.append(sim.state[D_STRIDE + D.VELOCITY])
        depth = max(sim.true_position[1] - 1.524, 0.0)
        deepest = max(deepest, depth)
        energies.append(mechanical_energy(sim.state, p) + 0.5 * p[slot(1, J.STOP_STIFFNESS)] * depth**2)
    assert -speed < min(velocities) <= 0 or speed < 0.1
    assert max(energies) <= 0.5 * 36.3 * speed**2 * 1.01
    assert np.diff(energies).max() < 1e-3 * energies[0]
    assert deepest < speed * math.sqrt(36.3 / p[slot(1, J.STOP_STIFFNESS)]) * 1.02


def test_a_stop_never_pulls() -> None:
    p, j = rotary_vector()
    for depth in (1e-5, 1e-3):
        for velocity in np.linspace(-20, 20, 41):
            assert stop_force(p[j + J.HIGH] + depth, velocity, p, j) <= 0
            assert stop_force(p[j + J.LOW] - depth, velocity, p, j) >= 0
    assert stop_force(0.0, 5.0, p, j) == 0.0


def test_full_command_into_the_stop_rests_there() -> None:
    """Valve full open for 6 s: the cylinder runs out, stops at 60 in and stays; full force bends the stop by the closed form."""
    sim = SimulatedRig(ornl())
    result = sim.run(np.tile([0.0, 10.0], (6000, 1)), 1e-3)
    p = sim.parameters.values
    force = p[C.SUPPLY_PRESSURE] * p[slot(1, J.AREA_A)]
    depth = result["prismatic.position"][-1] - 1.524
    assert 0 < depth < force / p[slot(1, J.STOP_STIFFNESS)] * 1.01
    assert np.ptp(result["prismatic.position"][-500:]) < 1e-5
    assert np.isfinite(result["tip.acceleration"]).all()


BACKLASH = {"effect": "backlash", "where": "rotary", "gap": "0.25 deg", "stiffness": 1.5e5, "damping": 300, "actuator_mass": 2.0}


def test_backlash_loses_the_gap_at_each_reversal() -> None:
    """Slow strokes: the load lies against one side, then the other; between them is the whole gap and a little twist."""
    sim = SimulatedRig(ornl(with_effects(BACKLASH)))
    sim.parameters.values[C.BENDING_STIFFNESS] = 0.0
    sim.reset()
    behind = []
    for time in np.arange(10000) * 1e-3:
        sim.advance([0.5 * math.sin(2 * math.pi * 0.2 * time), 0.0], 1e-3)
        behind.append(sim.state[D.ACTUATOR_POSITION] - sim.state[D.POSITION])
    settled = behind[2000:]
    assert max(settled) - min(settled) == pytest.approx(math.radians(0.25), rel=0.15)


def test_backlash_sensor_side() -> None:
    on_actuator = SimulatedRig(ornl(with_effects(BACKLASH | {"sensor_on": "actuator"})))
    for _ in range(300):
        on_actuator.advance([1.0, 0.0], 1e-3)
    assert on_actuator.true_signal("rotary.position") == on_actuator.state[D.ACTUATOR_POSITION]
    assert on_actuator.true_position[0] == on_actuator.state[D.POSITION]


def no_effects(content: Content) -> None:
    content["plant"]["effects"] = []


def test_force_axis_is_newtons_law() -> None:
    """A plain axis: constant force against viscous friction alone approaches F/B with the time constant M/B, in closed form."""
    rig = variant("force_axis", no_effects, with_effects({"effect": "viscous_friction", "where": "axis", "coefficient": 203.5}))
    sim = SimulatedRig(rig)
    result = sim.run(np.full((2000, 1), 0.5), 1e-3)
    p = sim.parameters.values
    mass, force, drag = p[slot(1, J.MASS)], 0.5 * 35.1507, 203.5
    expected = force / drag * (1 - np.exp(-drag / mass * result["t_s"]))
    assert result["axis.velocity"] == pytest.approx(expected, abs=1e-9)


def test_force_axis_on_a_slope() -> None:
    """Tilt: free fall along the slope, −g sin α."""
    rig = variant("force_axis", no_effects, with_effects({"effect": "gravity", "where": "axis", "tilt": "3 deg"}))
    sim = SimulatedRig(rig)
    set_motion(sim, 1, 0.2, 0.0)
    sim.run(np.zeros((300, 1)), 1e-3)
    assert sim.state[D_STRIDE + D.VELOCITY] == pytest.approx(-9.80665 * math.sin(math.radians(3)) * 0.3, rel=1e-9)


def test_a_turning_axis_with_an_unbalance_in_a_tilted_plane_is_a_pendulum() -> None:
    """Let go near its upright position: J θ'' = U sin α sin θ, and θ = θ₀ cosh(λt) with λ² = U sin α / J while it is small."""
    gravity = {"effect": "gravity", "where": "hub", "tilt": "20 deg", "unbalance": 0.05}
    sim = SimulatedRig(variant("cu_rigid_arm", no_effects, with_effects(gravity)))
    set_motion(sim, 0, 1e-4, 0.0)
    rate = math.sqrt(0.05 * math.sin(math.radians(20)) / 0.007)
    sim.run(np.zeros((1000, 1)), 1e-3)
    assert sim.state[D.POSITION] == pytest.approx(1e-4 * math.cosh(rate * 1.0), rel=1e-5)
