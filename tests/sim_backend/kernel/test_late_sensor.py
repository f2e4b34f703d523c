"""A window put on measured motion begins with what a late sensor still has to show: where the state was, by its position and rate."""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from sim_backend.kernel.batch import WindowPlan, carry, quiet, restart
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import D_STRIDE, SLOTS, TARGETS, D, Target, X
from sim_backend.plant import SimulatedRig

PERIOD_S = 1e-3
START, ROWS = 200, 60
RATE, REST = 0.05, 0.01  # m/s, m: the motion that is read
LINEAR = 1  # slot of a joint that slides
AXIS = ("force_axis", "axis.position", Target.POSITION + LINEAR, Target.VELOCITY + LINEAR)
TIP = ("ornl_testbed", "tip.deflection", Target.TIP_DEFLECTION, Target.TIP_DEFLECTION_RATE)


def late(name: str, signal: str, delay_s: float) -> tuple[SimulatedRig, Parameters, int]:
    text = load_rig(name).text.replace(
        "  effects:\n", f"  effects:\n    - {{effect: sensor_delay, where: 'sensor:{signal}', delay: {delay_s} s}}\n"
    )
    rig = rig_from_text(text)
    parameters = Parameters(rig)
    return SimulatedRig(rig), parameters, parameters.sensors[signal]


def plan_of(columns: tuple[int, int]) -> WindowPlan:
    """One window on a motion that is read as a straight line; until it begins, the rig is at rest."""
    targets = np.full((START + 3 * ROWS, TARGETS), np.nan)
    targets[:, columns[0]] = REST + RATE * PERIOD_S * (np.arange(len(targets)) - START)
    targets[:, columns[1]] = RATE
    return WindowPlan(np.zeros((len(targets), SLOTS)), np.array([START]), ROWS, 1, PERIOD_S, targets)


@pytest.mark.parametrize("of", [AXIS, TIP], ids=["axis", "tip"])
@pytest.mark.parametrize("delay_s", [0.008, 0.0033])
def test_a_window_begins_on_the_line_that_was_read(of: tuple[str, str, int, int], delay_s: float) -> None:
    name, signal, *columns = of
    sim, parameters, number = late(name, signal, delay_s)
    readings, _ = carry(sim.state, quiet(parameters), plan_of((columns[0], columns[1])))
    shown = int(delay_s / PERIOD_S) + 1  # rows in which the sensor shows what was before the window
    line = REST + RATE * PERIOD_S * np.arange(shown)
    lag_m = 2 * RATE * PERIOD_S if of is TIP else 0.0  # its bandwidth, and the vibration that begins
    np.testing.assert_allclose(readings[0, :shown, number], line, atol=1e-9 + lag_m)


@pytest.mark.parametrize(("of", "rate"), [(AXIS, LINEAR * D_STRIDE + D.VELOCITY), (TIP, int(X.SHAPE_1_RATE))], ids=["axis", "tip"])
def test_another_rate_at_the_start_turns_the_line_about_now(of: tuple[str, str, int, int], rate: int) -> None:
    """As it turns what is read without a delay: late and punctual sensors hang on a window's start alike, d later."""
    name, signal, *columns = of
    sim, parameters, number = late(name, signal, 0.008)
    plan, p = plan_of((columns[0], columns[1])), quiet(parameters)
    readings, kept = carry(sim.state, p, plan, keep=True)
    change = 1e-3
    moved = restart(kept, p, plan, rate, change)
    ages_s = PERIOD_S * np.arange(8, 0, -1)
    factor = 1.0 if of is AXIS else (moved[0, 0, number] - readings[0, 0, number]) / (-change * ages_s[0])  # of a shape in the deflection
    assert abs(factor) > 0.5
    np.testing.assert_allclose((moved - readings)[0, :8, number], -factor * change * ages_s, rtol=1e-6)
