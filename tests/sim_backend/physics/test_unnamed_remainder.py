"""The table of forces without a name: against closed forms of the motion it makes, and against its own knots."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, D, J
from sim_backend.physics.table import table_force
from tests.support.sim_backend.plants import Content, SimulatedRig, ideal, variant, with_effects

MASS_KG, GAIN_N_PER_V = 95.1089, 35.1507
SLOT = J_START + J_STRIDE  # a single sliding axis
PERIOD_S = 1e-3


def axis(**table: list[float]) -> SimulatedRig:
    """The plain axis with no effect but the table."""
    entry: Content = {"effect": "unnamed_remainder", "where": "axis", **table}
    return SimulatedRig(variant("force_axis", ideal, with_effects(entry)))


def run(sim: SimulatedRig, command_V: float, duration_s: float, start_m: float, velocity_mps: float = 0.0) -> dict[str, np.ndarray]:
    sim.reset([start_m])
    sim.state[D_STRIDE + D.VELOCITY] = velocity_mps
    return sim.run(np.full((round(duration_s / PERIOD_S), 1), command_V), PERIOD_S)


def test_a_table_over_velocity_sets_the_terminal_velocity() -> None:
    """−400 N s/m up to 0.02 m/s, −1200 beyond: 20 N end at 0.02 + 12/1200 = 0.03 m/s, with a time constant M/1200 at last."""
    sim = axis(velocity=[-0.1, -0.02, 0.02, 0.1], force=[104.0, 8.0, -8.0, -104.0])
    v = run(sim, 20.0 / GAIN_N_PER_V, 1.5, -0.05)["axis.velocity"]
    assert v[-1] == pytest.approx(0.03, rel=1e-6)
    tau_s = MASS_KG / 1200.0
    late = np.flatnonzero(v > 0.025)[0]
    assert (0.03 - v[late + 100]) / (0.03 - v[late]) == pytest.approx(math.exp(-0.1 / tau_s), rel=1e-3)


def test_a_straight_table_over_position_is_a_spring() -> None:
    """1000 N/m about 0.1 m, let go at 0.12 m: x = 0.1 + 0.02 cos √(k/M) t."""
    x = run(axis(position=[0.0, 0.2], force=[100.0, -100.0]), 0.0, 3.0, 0.12)["axis.position"]
    t = PERIOD_S * np.arange(x.size)
    assert np.max(np.abs(x - 0.1 - 0.02 * np.cos(math.sqrt(1000.0 / MASS_KG) * t))) < 1e-7


def test_a_crooked_table_over_position_keeps_the_energy() -> None:
    """½ M v² gained between two positions = area under the table."""
    knots, force = [0.05, 0.1, 0.15, 0.2], [30.0, 5.0, 60.0, -10.0]
    done = run(axis(position=knots, force=force), 0.0, 1.0, 0.04)
    x, v = done["axis.position"], done["axis.velocity"]
    there = np.argmax(x > 0.18)
    fine = np.linspace(0.04, x[there], 200001)
    work_J = np.trapezoid(np.interp(fine, knots, force), fine)  # np.interp holds the ends too
    assert 0.5 * MASS_KG * v[there] ** 2 == pytest.approx(work_J, rel=1e-6)


def test_a_table_over_the_command_adds_to_the_drive() -> None:
    """4 N at 1 V beside a drive of 35.15 N: the axis accelerates by (35.15 + 4) / M."""
    v = run(axis(command=[0.0, 2.0], force=[0.0, 8.0]), 1.0, 0.5, 0.0)["axis.velocity"]
    assert v[-1] == pytest.approx((GAIN_N_PER_V + 4.0) / MASS_KG * PERIOD_S * (v.size - 1), rel=1e-9)


@pytest.mark.parametrize("word", ["velocity", "position", "command"])
def test_between_knots_straight_and_beyond_them_constant(word: str) -> None:
    knots, force = [-0.3, -0.1, 0.05, 0.2, 0.9], [3.0, -2.0, 7.0, 7.5, 0.0]
    p = Parameters(axis(**{word: knots, "force": force}).rig).values
    for at in np.linspace(-1.5, 1.5, 61):
        variables = {"velocity": 9.0, "position": 9.0, "command": 9.0} | {word: float(at)}
        found = table_force(variables["velocity"], variables["position"], variables["command"], 9.0, p, SLOT)
        assert found == pytest.approx(np.interp(at, knots, force), abs=1e-12)


def test_a_table_of_zeros_costs_the_kernel_nothing() -> None:
    p = Parameters(axis(velocity=[-1.0, 1.0], force=[0.0, 0.0]).rig).values
    assert p[SLOT + J.TABLE_KNOTS] == 0.0


def test_a_braking_table_only_takes_energy() -> None:
    v = run(axis(velocity=[-0.05, 0.0, 0.05], force=[20.0, 0.0, -20.0]), 0.0, 2.0, 0.1, 0.08)["axis.velocity"]
    assert np.all(np.diff(np.abs(v)) <= 0.0)
    assert abs(v[-1]) < 0.002


def test_friction_over_position_takes_what_stands_under_the_table() -> None:
    """½ M v² lost between two positions = area under the friction, whatever the direction; Coulomb's 5 N of the file beside it."""
    knots, friction = [0.05, 0.1, 0.15], [0.0, 40.0, 10.0]
    entry: Content = {"effect": "unnamed_remainder", "where": "axis", "position": knots, "friction": friction}
    coulomb: Content = {"effect": "coulomb_friction", "where": "axis", "friction": 5.0}
    sim = SimulatedRig(variant("force_axis", ideal, with_effects(entry, coulomb)))
    for start, velocity in ((0.02, 0.4), (0.2, -0.4)):
        done = run(sim, 0.0, 0.4, start, velocity)
        x, v = done["axis.position"], done["axis.velocity"]
        first = np.argmax(np.abs(x - start) > 0.01)  # the bristles are bent by then
        fine = np.linspace(x[first], x[-1], 200001)
        work_J = abs(np.trapezoid(5.0 + np.interp(fine, knots, friction), fine))
        assert 0.5 * MASS_KG * (v[first] ** 2 - v[-1] ** 2) == pytest.approx(work_J, rel=2e-3)


def test_friction_is_never_less_than_none() -> None:
    """−30 N beside Coulomb's 5 N: the axis keeps its speed."""
    entry: Content = {"effect": "unnamed_remainder", "where": "axis", "position": [0.0, 0.2], "friction": [-30.0, -30.0]}
    coulomb: Content = {"effect": "coulomb_friction", "where": "axis", "friction": 5.0}
    v = run(SimulatedRig(variant("force_axis", ideal, with_effects(entry, coulomb))), 0.0, 0.3, 0.05, 0.1)["axis.velocity"]
    assert v == pytest.approx(0.1, rel=1e-12)
