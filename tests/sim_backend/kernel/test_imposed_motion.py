"""Joints whose motion is imposed, and the dead band of an electric drive, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from sim_backend.kernel.batch import WindowPlan, carry, quiet
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import TARGETS, Target
from sim_backend.plant import SimulatedRig

Array = np.ndarray
PERIOD_S = 0.001


def imposed(rig: Rig, slot: int, motion: tuple[Array, Array, Array], commands_V: Array) -> dict[str, Array]:
    """Readings of every sensor while one slot follows position, velocity and acceleration; a prismatic joint stays where it is."""
    rows = len(commands_V)
    targets = np.full((rows, TARGETS), np.nan)
    for column, values in zip((Target.POSITION, Target.VELOCITY, Target.ACCELERATION), motion, strict=True):
        targets[:, column + slot] = values
    if slot == 0:
        targets[:, Target.POSITION + 1] = 0.45
        targets[:, Target.VELOCITY + 1] = targets[:, Target.ACCELERATION + 1] = 0.0
    commands = np.zeros((rows, 2))
    commands[:, slot] = commands_V
    parameters, simulated = Parameters(rig), SimulatedRig(rig)
    plan = WindowPlan(commands, np.array([0]), rows, 1, PERIOD_S, targets)
    readings, _ = carry(simulated.state, quiet(parameters), plan)
    return {name: readings[0, :, number] for name, number in parameters.sensors.items()}


def test_a_held_chamber_balances_load_cell_friction_and_inertia() -> None:
    text = load_rig("seal_rig").text.replace("mass: 0.1 kg", "mass: 40 kg").replace(
        "  effects: []",
        "  effects:\n    - {effect: coulomb_friction, where: rod, friction: 4 N}\n"
        "    - {effect: viscous_friction, where: rod, coefficient: 100 N*s/m}\n"
        "    - {effect: pressure_friction, where: rod, coefficient: 1e-5 N/Pa}",
    )  # fmt: skip
    t, w = PERIOD_S * np.arange(4000), 2 * np.pi * 0.5
    x, v, a = -0.02 + 0.015 * np.sin(w * t), 0.015 * w * np.cos(w * t), -0.015 * w**2 * np.sin(w * t)
    force = np.full(4000, 150.0)
    pressure = imposed(rig_from_text(text), 1, (x, v, a), force)["rod.pressure_a"]
    area, sign = 491e-6, np.sign(v)
    expected = (force + 4 * sign + 100 * v + 40 * a) / (area - 1e-5 * sign)
    sliding = (np.abs(v) > 0.03) & (t > 1.1)
    assert pressure[sliding] == pytest.approx(expected[sliding], rel=2e-3)


def test_the_tip_of_a_turned_link_is_a_forced_oscillator() -> None:
    """A heavy tip on a light link: η'' + ω²η = −L θ'', from rest under θ = A (1 − cos pt)."""
    loaded = load_rig("cu_flexible_arm").text.replace("    mass_per_length: 0.1333 kg/m", "    mass_per_length: 0.0005 kg/m")
    text = loaded.replace(
        "  effects: []", "  effects:\n    - {effect: link_flexibility, where: link, bending_stiffness: 0.19424 N*m^2, damping_ratio: 0}"
    )
    t, length = PERIOD_S * np.arange(1500), 0.45
    own, p, size = np.sqrt(3 * 0.19424 / (0.05 * length**3)), 2 * np.pi * 1.1, 0.1
    theta, theta_d, theta_dd = size * (1 - np.cos(p * t)), size * p * np.sin(p * t), size * p**2 * np.cos(p * t)
    deflection = imposed(rig_from_text(text), 0, (theta, theta_d, theta_dd), np.zeros(1500))["tip.deflection"]
    expected = -length * size * p**2 * (np.cos(p * t) - np.cos(own * t)) / (own**2 - p**2)
    assert np.max(np.abs(deflection - expected)) < 0.02 * np.max(np.abs(expected))


@pytest.mark.parametrize(("command_V", "left_V"), [(0.4, 0.0), (-0.4, 0.0), (2.0, 1.5), (-2.0, -1.5)])
def test_a_dead_band_takes_its_width_off_the_command_of_an_electric_drive(command_V: float, left_V: float) -> None:
    text = load_rig("force_axis").text
    text = "".join(line for line in text.splitlines(keepends=True) if "- {effect:" not in line)
    simulated = SimulatedRig(rig_from_text(text + "    - {effect: valve_deadband, where: axis, overlap: 0.05}\n"))
    simulated.reset([0.1])
    velocity = simulated.run(np.full((101, 1), command_V), PERIOD_S)["axis.velocity"]
    assert velocity[100] == pytest.approx(35.1507 * left_V / 95.1089 * 0.1, rel=1e-6, abs=1e-12)
