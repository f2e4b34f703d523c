"""Weak forms of the balance equations against closed forms: an equation that holds comes out even, the broken one is named."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from gap.balance.balances import Balance, balances
from gap.balance.dependence import dependences, operating_variables
from gap.balance.weak_form import bump
from gap.data.measured import Measured, on_grid
from sim_backend.plant import SimulatedRig

PERIOD_S = 0.001
T = PERIOD_S * np.arange(6000)


def log_of(rig: Rig, columns: Mapping[str, np.ndarray]) -> Measured:
    return on_grid(Path("closed_form.csv"), {"t_s": T, **columns}, rig, "")


def held(force: np.ndarray) -> np.ndarray:
    """A force that acts continuously, as a command held over every row: its mean over the row."""
    return np.append(0.5 * (force[1:] + force[:-1]), force[-1])


def axis(*effects: str) -> Rig:
    text = load_rig("force_axis").text
    return rig_from_text("".join(line for line in text.splitlines(keepends=True) if "- {effect:" not in line) + "".join(effects))


VISCOUS = "    - {effect: viscous_friction, where: axis, coefficient: 203.5 N*s/m}\n"
COULOMB = "    - {effect: coulomb_friction, where: axis, friction: 20 N}\n"


def moved(coulomb_N: float, noise_m: float = 0.0) -> dict[str, np.ndarray]:
    """x = 0.1 + 0.05 sin wt with the force it takes: M x'' + 203.5 x' + Fc sign x'."""
    w = 2 * np.pi * 0.8
    x, v, a = 0.1 + 0.05 * np.sin(w * T), 0.05 * w * np.cos(w * T), -0.05 * w**2 * np.sin(w * T)
    noise = noise_m * np.random.default_rng(3).normal(size=T.size)
    return {"axis.position": x + noise, "axis.command_V": held(95.1089 * a + 203.5 * v + coulomb_N * np.sign(v)) / 35.1507}


@pytest.mark.parametrize("rows", [9, 50, 401])
def test_the_bump_gives_means_of_rate_and_acceleration(rows: int) -> None:
    """Of a parabola: the rate in the middle, and the acceleration, whatever the support."""
    test, t = bump(rows, PERIOD_S), PERIOD_S * (np.arange(rows) - (rows - 1) / 2)
    y = 3.0 * t**2 + 0.7 * t + 5.0
    assert test.rate @ y == pytest.approx(0.7, rel=1e-9)
    assert test.acceleration @ y == pytest.approx(6.0, rel=1e-9)
    assert test.value @ np.ones(rows) == pytest.approx(1.0, rel=1e-3)
    assert test.held @ np.ones(rows) == pytest.approx(1.0, rel=1e-12)


def force_balance(rig: Rig, columns: Mapping[str, np.ndarray], noise_m: float = 1e-7) -> Balance:
    (found,) = balances(log_of(rig, columns), rig, {"axis.position": noise_m})
    assert (found.equation, found.where, found.unit) == ("force balance", "axis", "N")
    return found


def test_a_true_force_balance_comes_out_even() -> None:
    found = force_balance(axis(VISCOUS, COULOMB), moved(20.0))
    assert np.max(np.abs(found.residual)) < 0.1  # of 110 N
    assert found.z < 0.1


def test_a_table_of_forces_takes_part_in_the_balance() -> None:
    """A spring of 300 N/m about 0.1 m beside the friction, in the motion and as a table in the file."""
    columns = moved(20.0)
    columns["axis.command_V"] = columns["axis.command_V"] + held(300.0 * (columns["axis.position"] - 0.1)) / 35.1507
    assert np.max(np.abs(force_balance(axis(VISCOUS, COULOMB), columns).residual)) > 10.0
    table = "    - {effect: unnamed_remainder, where: axis, position: [0.04 m, 0.16 m], force: [18 N, -18 N]}\n"
    assert np.max(np.abs(force_balance(axis(VISCOUS, COULOMB, table), columns).residual)) < 0.1


def test_a_table_of_friction_takes_part_too() -> None:
    table = "    - {effect: unnamed_remainder, where: axis, position: [0.04 m, 0.16 m], friction: [20 N, 20 N]}\n"
    assert np.max(np.abs(force_balance(axis(VISCOUS, table), moved(20.0)).residual)) < 0.1


GRAVITY = "    - {effect: gravity, where: %s, tilt: 12 deg%s}\n"


def test_gravity_along_a_slope_takes_part_in_the_balance() -> None:
    """The same sliding motion up a slope: M g sin 12° more at every row."""
    columns, tilted = moved(20.0), GRAVITY % ("axis", "")
    columns["axis.command_V"] = columns["axis.command_V"] + 95.1089 * 9.80665 * np.sin(np.deg2rad(12)) / 35.1507
    assert np.max(np.abs(force_balance(axis(VISCOUS, COULOMB, tilted), columns).residual)) < 0.1
    assert np.mean(force_balance(axis(VISCOUS, COULOMB), columns).residual) == pytest.approx(193.9, rel=1e-2)


def test_gravity_on_an_unbalance_takes_part_in_the_balance() -> None:
    """A pendulum swung through ±0.9 rad about upright: J θ'' + B θ' − U sin 12° sin θ, which the drive must give (the angle is exact)."""
    text, w = load_rig("cu_rigid_arm").text, 2 * np.pi * 0.8
    x, v, a = 0.9 * np.sin(w * T), 0.9 * w * np.cos(w * T), -0.9 * w**2 * np.sin(w * T)
    torque = 0.007 * a + 0.08152 * v - 0.4 * np.sin(np.deg2rad(12)) * np.sin(x)
    columns = {"hub.position": x, "hub.command_V": held(torque) / 0.15741}

    def left(effects: str) -> np.ndarray:
        rig = rig_from_text(text + effects)
        (found,) = balances(log_of(rig, columns), rig, {"hub.position": 1e-7})
        assert (found.equation, found.where, found.unit) == ("force balance", "hub", "N*m")
        return found.residual

    assert np.max(np.abs(left(GRAVITY % ("hub", ", unbalance: 0.4 N*m")))) < 1e-3  # of 0.45 N m
    assert np.max(np.abs(left(""))) == pytest.approx(0.4 * np.sin(np.deg2rad(12)) * np.sin(0.9), rel=0.05)


def test_its_noise_is_what_the_sensor_makes_of_it() -> None:
    found = force_balance(axis(VISCOUS), moved(0.0, 2e-6), 2e-6)
    assert np.std(found.residual) < 1.1 * np.median(found.sd)
    assert np.std(found.residual) > 0.02


def test_missing_friction_is_an_imbalance_that_jumps_with_the_velocity() -> None:
    rig = axis(VISCOUS)
    found = force_balance(rig, moved(20.0))
    assert found.z > 3
    strongest = dependences(found, log_of(rig, moved(20.0)), rig)
    assert strongest[0].variable in ("axis.velocity", "axis.command_V")
    by_velocity = next(d for d in strongest if d.variable == "axis.velocity")
    assert by_velocity.means[0] == pytest.approx(-20.0, abs=1.0)
    assert by_velocity.means[-1] == pytest.approx(20.0, abs=1.0)
    assert "N at" in by_velocity.text()


def test_at_rest_friction_takes_what_it_must() -> None:
    """A pushed axis that does not slide breaks no force balance. It stops where the sine turns."""
    columns = moved(20.0)
    stop = 2812
    columns["axis.position"] = np.where(T[stop] > T, columns["axis.position"], columns["axis.position"][stop])
    columns["axis.command_V"] = np.where(T[stop] > T, columns["axis.command_V"], 0.3)
    found = force_balance(axis(VISCOUS, COULOMB), columns)
    assert found.rows.max() < stop
    assert found.z < 1


def test_a_joint_pressed_on_its_stop_is_no_imbalance() -> None:
    """The stop takes what the drive presses with, and no equation knows it: these rows are left out."""
    rig, columns, stop = axis(VISCOUS, COULOMB), moved(20.0), 3000
    assert rig.plant is not None
    high = rig.plant.joints["axis"].travel[1]
    columns["axis.position"] = np.where(T[stop] > T, columns["axis.position"], high)
    columns["axis.command_V"] = np.where(T[stop] > T, columns["axis.command_V"], 5.0)
    found = force_balance(rig, columns)
    assert found.rows.max() < stop
    before = found.rows < stop - 60  # the last support holds the jump onto the stop, which takes no time here
    assert np.abs(found.residual[before]).max() < 0.1 * 5.0 * 35.1507


def test_what_a_log_lacks_is_no_variable_of_an_imbalance() -> None:
    """Only chamber B's pressure was measured: nothing is said over that of A."""
    rig = load_rig("rotary_actuator").rig
    wave = np.sin(2 * np.pi * T)
    log = log_of(rig, {"shaft.position": 0.1 * wave, "shaft.command_V": wave, "shaft.pressure_b_Pa": 3e6 + 1e5 * wave})
    told = operating_variables(log, rig)
    assert "shaft.pressure_b" in told
    assert not [name for name in told if "pressure_a" in name or "difference" in name]


FLEXIBLE = "  effects:\n    - {effect: link_flexibility, where: link, bending_stiffness: 0.249 N*m^2, damping_ratio: 0}\n"


def swung(stiffness: float) -> dict[str, np.ndarray]:
    """Hub at rest: the tip swings freely at the first frequency of a link of this stiffness with 50 g at 0.45 m (rod taken light)."""
    mass = 0.05 + 0.1333 * 0.45 * 33 / 140
    w = np.sqrt(3 * stiffness / (mass * 0.45**3))
    still = np.zeros(T.size)
    return {"rotary.position": still, "prismatic.position": still + 0.45, "tip.deflection_m": 0.01 * np.cos(w * T)}


SIGMA = {"rotary.position": 1e-5, "prismatic.position": 1e-5, "tip.deflection": 1e-5}


@pytest.mark.parametrize(("stiffness", "holds"), [(0.249, True), (0.6, False)])
def test_a_swinging_tip_shows_whether_the_stiffness_is_right(stiffness: float, holds: bool) -> None:
    rig = rig_from_text(load_rig("cu_flexible_arm").text.replace("  effects: []\n", FLEXIBLE))
    (found,) = balances(log_of(rig, swung(stiffness)), rig, SIGMA)
    assert (found.equation, found.where) == ("link bending", "link")
    assert (found.z < 1.5) if holds else (found.z > 5)


def test_a_rigid_link_must_not_bend() -> None:
    rig = load_rig("cu_flexible_arm").rig
    (found,) = balances(log_of(rig, swung(0.249)), rig, SIGMA)
    assert (found.unit, found.z > 5) == ("m", True)


KEPT = ("viscous_friction", "cross_leakage")


def arm(*without: str) -> Rig:
    """The testbed with a rigid link, viscous friction and leakage only, and pressure sensors in the rotary actuator's chambers."""
    kept = [name for name in KEPT if name not in without]
    lines = [
        line
        for line in load_rig("ornl_testbed").text.splitlines(keepends=True)
        if "- {effect:" not in line or any(f"effect: {name}," in line for name in kept)
    ]
    sensors = "".join(f"    rotary.pressure_{k}: {{resolution: 100 Pa, low: 0 Pa, high: 30 MPa}}\n" for k in "ab")
    return rig_from_text("".join(lines).replace("  sensors:\n", "  sensors:\n" + sensors, 1))


def test_the_broken_equation_of_an_arm_is_named() -> None:
    """Commands open loop; the model without leakage breaks the chambers' flow balance and no force balance."""
    truth = arm()
    commands = np.column_stack([0.8 * np.sin(2 * np.pi * 0.6 * T) + 0.3 * np.sin(2 * np.pi * 1.7 * T), 0.2 * np.sin(2 * np.pi * 0.5 * T)])
    run = SimulatedRig(truth).run(commands, PERIOD_S)
    names = ["rotary.position", "prismatic.position"]
    columns = {name: run[name] for name in names} | {f"rotary.pressure_{k}_Pa": run[f"rotary.pressure_{k}"] for k in "ab"}
    columns |= {"rotary.command_V": commands[:, 0], "prismatic.command_V": commands[:, 1]}
    sigma = dict.fromkeys(names, 1e-6) | {"rotary.pressure_a": 50.0, "rotary.pressure_b": 50.0}
    right = {(b.equation, b.where): b.z for b in balances(log_of(truth, columns), truth, sigma)}
    wrong = balances(log_of(truth, columns), arm("cross_leakage"), sigma)
    assert max(right.values()) < 1.0
    assert (wrong[0].equation, wrong[0].where) == ("chamber flow balance", "rotary")
    assert wrong[0].z > 3 * max(right.values())
    force = next(b for b in wrong if b.equation == "force balance")
    assert force.z < 1.0
