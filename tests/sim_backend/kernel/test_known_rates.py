"""What many periods in one call need not compute again changes no bit: calls of one period each agree with them exactly, for every rig.

For every effect, also those of a library with a law at each hook: tests/sim_backend/effects/test_effects.py.
"""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig
from sim_backend.kernel import kernel
from sim_backend.kernel.batch import WindowPlan, carry
from sim_backend.kernel.measured_state import begin, correct
from sim_backend.kernel.servo_run import servo_volts
from sim_backend.memory.layout import D_STRIDE, DIFFERENTIAL, J_START, J_STRIDE, TARGETS, C, D, J, Kind
from sim_backend.physics.link import fastest_rate
from sim_backend.physics.table import COMMAND
from sim_backend.plant import SimulatedRig

PERIOD_S = 1e-3
ROWS = 400
RIGS = ("ornl_testbed", "ornl_testbed_can", "rotary_actuator", "analogue_axis", "force_axis", "cu_rigid_arm", "cu_flexible_arm", "seal_rig")


def commands(joints: int) -> np.ndarray:
    t = np.arange(ROWS) * PERIOD_S
    return np.column_stack([2.0 * np.sin(2 * np.pi * (3.0 + joint) * t) for joint in range(joints)])


def shipped() -> SimulatedRig:
    return SimulatedRig(load_rig("ornl_testbed").rig)


def with_a_spool_that_follows_at_once() -> SimulatedRig:
    sim = shipped()
    sim.parameters.values[J_START + J.VALVE_TIME] = 0.0
    return sim


def with_a_table_of_the_command() -> SimulatedRig:
    sim = shipped()
    p, j = sim.parameters.values, J_START + J_STRIDE
    p[j + J.TABLE_KNOTS], p[j + J.TABLE_INPUT] = 2.0, COMMAND
    p[j + J.TABLE_AT_0 : j + J.TABLE_AT_0 + 2] = -5.0, 5.0
    p[j + J.TABLE_FORCE_0 : j + J.TABLE_FORCE_0 + 2] = -200.0, 200.0
    return sim


def with_short_steps() -> SimulatedRig:
    sim = shipped()
    sim.parameters.values[C.STEP] = 3e-4
    return sim


def agree(together: SimulatedRig, single: SimulatedRig) -> None:
    """Every state and signal at the start of every period, and the whole state in the end."""
    joints = len(together.joints)
    volts = commands(joints)
    found = together.run(volts, PERIOD_S, sense=True)
    names = together.signal_names()
    for row in range(ROWS):
        assert [single.true_signal(name) for name in names] == [found[name][row] for name in names], row
        np.testing.assert_array_equal(single.sense(), found["raw"][row])
        single.advance(volts[row].tolist(), PERIOD_S)
    np.testing.assert_array_equal(together.state, single.state)


@pytest.mark.parametrize(
    ("make", "stay"),
    [(shipped, True), (with_short_steps, True), (with_a_spool_that_follows_at_once, False), (with_a_table_of_the_command, False)],
)
def test_many_periods_in_one_call_are_those_of_single_calls(make, stay) -> None:  # type: ignore[no-untyped-def]
    together = make()
    assert kernel.rates_stay(together.parameters.values) is stay
    agree(together, make())


@pytest.mark.parametrize("name", RIGS)
def test_so_of_every_shipped_rig(name: str) -> None:
    agree(SimulatedRig(load_rig(name).rig), SimulatedRig(load_rig(name).rig))


def test_so_against_the_stops() -> None:
    """Full command into both ends: contact, and spools at the end of their bore."""
    rigs = [shipped(), shipped()]
    for rig in rigs:
        rig.reset([1.0, 1.35])
    volts = np.full((ROWS, 2), 10.0)
    volts[ROWS // 2 :] = -10.0
    rigs[0].run(volts, PERIOD_S)
    for row in volts.tolist():
        rigs[1].advance(row, PERIOD_S)
    np.testing.assert_array_equal(rigs[0].state, rigs[1].state)


def test_so_of_windows_put_on_measured_motion() -> None:
    sim, single = shipped(), shipped()
    volts, targets = commands(2), np.full((ROWS, TARGETS), np.nan)
    targets[:, :4] = 0.02, 1.0, 0.1, -0.05  # somewhere else than the windows arrive
    plan = WindowPlan(volts, np.array([50, 170]), 120, 1, PERIOD_S, targets)
    readings, kept = carry(sim.state, sim.parameters.values, plan, keep=True)
    resolutions = np.array([load_rig("ornl_testbed").rig.plant.sensors[name].resolution for name in single.channels])  # type: ignore[union-attr]
    begin(single.state, single.parameters.values, targets, PERIOD_S)
    for row in range(50 + 2 * 120):
        if row in (50, 170):
            correct(single.state, single.parameters.values, targets, row, PERIOD_S)
            np.testing.assert_array_equal(single.state, kept[(row - 50) // 120])
        if row >= 50:
            window, sample = divmod(row - 50, 120)
            np.testing.assert_array_equal(single.sense() * resolutions, readings[window, sample])
        single.advance(volts[row].tolist(), PERIOD_S)


@pytest.mark.slow  # nothing else in the default tests compiles it
def test_so_of_servos_on_references() -> None:
    together, single = shipped(), shipped()
    references = np.column_stack([0.05 * commands(2), np.zeros((ROWS, 2))])
    references[:, 1] += 1.0
    servos = np.array([[20.0, 1.0, 5.0], [30.0, 1.0, 5.0]])
    together.follow(references, servos, PERIOD_S, 1)
    for row in range(ROWS):
        single.advance([servo_volts(single.state, references, servos, row, slot) for slot in (0, 1)], PERIOD_S)
    np.testing.assert_array_equal(together.state, single.state)


def test_rates_of_imposed_motion_and_of_unused_slots() -> None:
    sim = shipped()
    p = sim.parameters.values
    p[J_START + J.KIND] = float(Kind.IMPOSED)
    assert not kernel.rates_stay(p)
    p[J_START + J.KIND] = float(Kind.UNUSED)
    assert kernel.rates_stay(p)


def test_new_commands_change_no_rates_but_those_of_the_spools() -> None:
    sim = shipped()
    x, p, w = sim.state, sim.parameters.values, sim._work
    known = np.zeros(DIFFERENTIAL)
    kernel.hold_terms(x, p, w)
    kernel.start_air(x, p, w)
    kernel.evaluate(x, p, w, known, PERIOD_S)
    kernel.start_period(x, 3.0, -4.0)
    kernel.start_step(x, p, w, 0.0, 1.0, PERIOD_S)
    anew = np.zeros(DIFFERENTIAL)
    kernel.evaluate(x, p, w, anew, PERIOD_S)
    spools = {slot * D_STRIDE + state for slot in (0, 1) for state in (D.SPOOL, D.SPOOL_RATE)}
    assert {int(number) for number in np.flatnonzero(known != anew)} <= spools
    kernel.renew_spools(x, p, w, known)
    np.testing.assert_array_equal(known, anew)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.005, 0.05, 0.5, -0.1])
def test_the_step_is_that_of_the_fastest_rate_at_every_length(damping_ratio: float) -> None:
    sim = shipped()
    x, p = sim.state, sim.parameters.values
    p[C.LINK_DAMPING] = damping_ratio
    p[J_START + J_STRIDE + J.LOW] = 0.02
    seen = set()
    for length in np.geomspace(0.02, 2.0, 400):
        x[D_STRIDE + D.POSITION] = length
        longest = min(float(p[C.STEP]), 2.0 / fastest_rate(length, p))
        wanted = max(int(np.ceil(PERIOD_S / longest - 1e-9)), 1)
        assert kernel.steps_within(PERIOD_S, x, p) == wanted
        seen.add(wanted)
    assert len(seen) > 3
