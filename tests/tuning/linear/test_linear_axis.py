"""A single axis linearised: Merritt's resonance of a cylinder, steady speeds of a valve, and the plant stepping in time."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from config.errors import ManeuverError
from config.loading.load import load_rig
from config.schema.rig import Rig
from sim_backend.memory.layout import J
from sim_backend.plant import SimulatedRig
from tests.support.sim_backend.plants import variant, with_effects, without
from tuning.linear.closed_loop import modes
from tuning.linear.linear_arm import LinearArm
from tuning.linear.linear_axis import linear_axis
from tuning.loop_design.axis_design import axis_places


@pytest.fixture(scope="module")
def axis() -> Rig:
    return load_rig("analogue_axis").rig


def _oil_and_mass_Hz(position: float) -> float:
    """40/25 mm x 300 mm, 60 cm³ dead volumes, 120 kg, 1.4 GPa."""
    a, b = pi / 4 * 0.04**2, pi / 4 * (0.04**2 - 0.025**2)
    stiffness = 1.4e9 * (a**2 / (60e-6 + a * position) + b**2 / (60e-6 + b * (0.3 - position)))
    return sqrt(stiffness / 120.0) / (2 * pi)


@pytest.mark.parametrize("position", [0.02, 0.15, 0.28])
def test_resonance_of_mass_on_oil(axis: Rig, position: float) -> None:
    """Some percent above 2 % where the bulk modulus follows the pressure; the less damped of the two pairs that are not the valve's."""
    found = modes(linear_axis(axis, position, 0.03).a)
    nearest = np.argmin(np.abs(found.frequency_Hz - _oil_and_mass_Hz(position)))
    assert found.frequency_Hz[nearest] == pytest.approx(_oil_and_mass_Hz(position), rel=0.03)
    assert 0.0 < found.damping_ratio[nearest] < 0.2


def test_gain_is_that_of_the_orifices_both_ways(axis: Rig) -> None:
    """K/A √(p/(1 + r³)) a full scale out, √r times that back, r the ratio of the areas (as `new-rig` writes them): 47.9 and 37.4 mm/s/V."""
    slow = np.array([2 * pi * 0.5])
    out, back = (linear_axis(axis, 0.15, opening) for opening in (0.3, -0.3))
    gains = [float(abs(one.response(slow, one.position)[0]) * slow[0]) for one in (out, back)]
    assert gains == pytest.approx([0.0479, 0.0374], rel=0.04)  # 2 bar of return pressure and leakage are not in the formula


def test_axis_moves_as_the_plant_does(axis: Rig) -> None:
    """A step of 50 mV from rest, dry friction and valve hysteresis off: position over 0.3 s against the kernel's own integration."""
    plant = SimulatedRig(axis)
    for gone in (J.COULOMB, J.STICTION, J.HYSTERESIS):
        plant.parameters.values[plant.parameters.offset(gone, "axis")] = 0.0
    plant.reset([0.15])
    still = plant.run(np.zeros((300, 1)), 0.001)["axis.position"]
    plant.reset([0.15])
    moved = plant.run(np.full((300, 1), 0.05), 0.001)["axis.position"] - still
    arm = linear_axis(axis, 0.15)
    n = len(arm.b)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = arm.a, arm.b
    one, state, expected = expm(block * 0.001), np.append(np.zeros(n), 0.05), []
    for _ in range(300):
        expected.append(arm.position @ state[:n])
        state = one @ state
    assert np.abs(moved - expected).max() < 0.05 * np.abs(expected).max()


def _stepped(axis: Rig, volts: float, more_V: float) -> np.ndarray:
    """What `more_V` on top of a command does to the position in 60 ms, after half a second of that command; hysteresis off."""
    paths = []
    for command in (volts, volts + more_V):
        plant = SimulatedRig(axis)
        plant.parameters.values[plant.parameters.offset(J.HYSTERESIS, "axis")] = 0.0
        plant.reset([0.15])
        plant.run(np.full((500, 1), volts), 0.001)
        paths.append(plant.run(np.full((60, 1), command), 0.001)["axis.position"])
    return paths[1] - paths[0]


def _linear_step(arm: LinearArm, volts: float) -> np.ndarray:
    n = len(arm.b)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = arm.a, arm.b
    one, state, found = expm(block * 0.001), np.append(np.zeros(n), volts), []
    for _ in range(60):
        found.append(arm.position @ state[:n])
        state = one @ state
    return np.array(found)


def test_friction_while_it_slides_is_that_of_the_plant(axis: Rig) -> None:
    """At 0.3 V it slides at 14 mm/s; 10 mV more, dry friction on."""
    seen = _stepped(axis, 0.3, 0.01)
    expected = _linear_step(linear_axis(axis, 0.157, 0.03, friction=True), 0.01)
    assert np.abs(seen - expected).max() < 0.05 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("effect", "holds"),
    [
        ({"effect": "pressure_friction", "coefficient": "4 N/bar"}, True),
        ({"effect": "unnamed_remainder", "position": ["0.1 m", "0.2 m"], "friction": ["300 N", "300 N"]}, True),
        ({"effect": "unnamed_remainder", "position": ["0.1 m", "0.2 m"], "force": ["0 N", "1e-6 N"]}, False),
    ],
)
def test_dry_friction_of_any_effect_is_taken_in_or_left_out(effect: dict[str, Any], holds: bool) -> None:
    """Sliding as the plant does with it; without it, as one whose friction was deleted; held where something rubs."""
    smooth = variant("analogue_axis", without("coulomb_friction", "stiction"))
    rough = variant("analogue_axis", without("coulomb_friction", "stiction"), with_effects({**effect, "where": "axis"}))
    assert linear_axis(rough, 0.15).a == pytest.approx(linear_axis(smooth, 0.15).a, rel=1e-5, abs=1e-5)
    assert {place.held for place in axis_places(rough) if not place.opening} == {holds}
    expected = _linear_step(linear_axis(rough, 0.157, 0.03, friction=True), 0.01)
    assert np.abs(_stepped(rough, 0.3, 0.01) - expected).max() < 0.05 * np.abs(expected).max()


def test_friction_holds_it_at_rest_as_the_plants_does(axis: Rig) -> None:
    """0.2 mV, so little that the bristles hardly bend, both ways (they are bent already, and softer one way), against the kernel's own;
    without them it would run away."""
    seen = 0.5 * (_stepped(axis, 0.0, 0.0002) - _stepped(axis, 0.0, -0.0002))
    held, free = (linear_axis(axis, 0.15, friction=friction) for friction in (True, False))
    assert np.abs(seen - _linear_step(held, 0.0002)).max() < 0.05 * np.abs(seen).max()
    assert _linear_step(free, 0.0002)[-1] > 1.5 * seen[-1]


def test_a_held_axis_rings_on_bristles_and_oil(axis: Rig) -> None:
    """√((k_oil + σ₀)/m), 86 Hz, a little changed by the bristles' damping."""
    found = modes(linear_axis(axis, 0.15, friction=True, valve_lag=False).a)
    rings = found.frequency_Hz[found.damping_ratio < 0.9]
    stiffness = 120.0 * (2 * pi * _oil_and_mass_Hz(0.15)) ** 2 + 2.14e7
    assert rings.tolist() == [pytest.approx(sqrt(stiffness / 120.0) / (2 * pi), rel=0.03)]


def test_a_valve_without_lag_leaves_no_fast_poles() -> None:
    arm = linear_axis(load_rig("rotary_actuator").rig, 0.0, 0.03)
    assert len(arm.b) == 4
    assert np.abs(np.linalg.eigvals(arm.a)).max() < 1000.0


def test_an_axis_without_a_valve_is_refused() -> None:
    with pytest.raises(ManeuverError, match="no hydraulic axis"):
        linear_axis(load_rig("force_axis").rig, 0.0)
