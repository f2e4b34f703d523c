"""A log begins where its encoders read, through the scales and offsets that the model says they have."""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from sim_backend.kernel.batch import WindowPlan, carry, quiet
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import D_STRIDE, SLOTS, TARGETS, D, Target
from sim_backend.plant import SimulatedRig
from tests.support.sim_backend.effect_library import rig_text

PERIOD_S = 1e-3
START, ROWS = 300, 50
EXTENSION_M, LINEAR = 0.75, 1
FACTOR, OFFSET_M = 1.135, 0.02
ROTARY_CHAMBERS, LINEAR_CHAMBERS = ([slot * D_STRIDE + chamber for chamber in (D.PRESSURE_A, D.PRESSURE_B)] for slot in (0, LINEAR))
HIGH_M = 1.524  # travel of the extension


def first_state(read_m: float, entry: str = "") -> np.ndarray:
    """The state at the start of the first window, of a rig whose encoder of the extension reads `read_m` at rest, while the rotary
    joint turns on its command."""
    rig = rig_from_text(rig_text(entry)) if entry else load_rig("ornl_testbed").rig
    sim, parameters = SimulatedRig(rig), Parameters(rig)
    sim.reset([0.0, min(read_m, HIGH_M)])
    targets = np.full((START + 2 * ROWS, TARGETS), np.nan)
    targets[:, Target.POSITION + LINEAR], targets[:, Target.VELOCITY + LINEAR] = read_m, 0.0
    commands = np.zeros((len(targets), SLOTS))
    commands[:, 0] = 1.5
    plan = WindowPlan(commands, np.array([START]), ROWS, 1, PERIOD_S, targets)
    return carry(sim.state, quiet(parameters), plan, keep=True)[1][0]


@pytest.mark.parametrize(
    ("read_m", "entry"),
    [
        (FACTOR * EXTENSION_M, f"effect: sensor_scale, where: 'sensor:prismatic.position', factor: {FACTOR}"),
        (EXTENSION_M + OFFSET_M, f"effect: sensor_offset, where: 'sensor:prismatic.position', offset: {OFFSET_M} m"),
    ],
)
def test_pressures_at_the_first_window_are_those_of_the_true_extension(read_m: float, entry: str) -> None:
    """The arm's inertia on the way there is that of the true extension. With that of the reading the rotary chambers are 1 to 3 bar off."""
    found, true = first_state(read_m, entry), first_state(EXTENSION_M)
    np.testing.assert_allclose(found[ROTARY_CHAMBERS], true[ROTARY_CHAMBERS], atol=1.0)
    assert found[LINEAR * D_STRIDE + D.POSITION] == pytest.approx(EXTENSION_M, abs=1e-6)


def test_a_reading_beyond_the_stop_begins_at_the_stop() -> None:
    """The stop does not throw the rod out: pressed a centimetre into it the chambers would be 16 and 88 bar off."""
    found, true = first_state(HIGH_M + 0.01), first_state(HIGH_M)
    np.testing.assert_allclose(found[LINEAR_CHAMBERS], true[LINEAR_CHAMBERS], atol=2e4)
