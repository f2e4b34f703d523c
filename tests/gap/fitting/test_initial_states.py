"""What differs from window to window is taken out: the oil's temperature, and the form of friction before it slides."""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from gap.data.windows import Experiment
from gap.fitting.evaluation import Evaluation, evaluate, judged, mean_cost
from gap.fitting.initial_states import Projection, breaking_away, forms_of_friction, start_states
from gap.fitting.model import Model
from sim_backend.memory.layout import J_START, H, J
from sim_backend.physics.friction import faded, sliding_level
from tests.support.gap import testbed_logs

TEXT = load_rig("ornl_testbed").text
RIG = rig_from_text(TEXT)


def logged(machine: Rig) -> Experiment:
    """Both joints slowly back and forth with reversals, the machine's own readings; windows of the rig file as it is shipped."""
    t = 0.001 * np.arange(5000)
    command = np.column_stack([0.25 * np.sin(2 * np.pi * 0.45 * t), 0.6 * np.sin(2 * np.pi * 0.35 * t + 0.6)])
    return testbed_logs.experiment(machine, command, 7, RIG)


def without(projection: Projection, known: int | slice) -> Projection:
    """The same with some of its unknowns known exactly."""
    a = np.delete(projection.sensitivity, known, axis=2)
    gain = np.linalg.solve(np.einsum("wnk,wnl->wkl", a, a) + np.eye(a.shape[2]), a.transpose(0, 2, 1))
    return Projection(a, gain)


def cost(experiment: Experiment, projection: Projection, now: Evaluation) -> float:
    return mean_cost([judged(experiment, now.readings, projection, None)])


def test_friction_that_yields_otherwise_is_no_gap() -> None:
    experiment = logged(rig_from_text(TEXT.replace("bristle_stiffness: 3e5", "bristle_stiffness: 1.5e5")))
    p, now = Model(RIG, (), np.empty(0)).vector(), evaluate(experiment, Model(RIG, (), np.empty(0)), None)
    forms = len(forms_of_friction(p))
    stiff = without(now.projection, slice(-forms, None))
    assert cost(experiment, stiff, now) > 1.7
    assert mean_cost([now]) < 1.1


def test_friction_that_slides_stays_a_gap() -> None:
    """Another third of Coulomb friction is another constant, not another form: what the form takes away of it is little."""
    experiment = logged(rig_from_text(TEXT.replace("where: rotary, friction: 105", "where: rotary, friction: 140")))
    p, now = Model(RIG, (), np.empty(0)).vector(), evaluate(experiment, Model(RIG, (), np.empty(0)), None)
    stiff = without(now.projection, slice(-len(forms_of_friction(p)), None))
    assert mean_cost([now]) > 10.0
    assert mean_cost([now]) > 0.5 * cost(experiment, stiff, now)


def test_oil_of_another_temperature_is_no_gap() -> None:
    experiment = logged(rig_from_text(TEXT.replace("initial_temperature: 40", "initial_temperature: 42")))
    p, now = Model(RIG, (), np.empty(0)).vector(), evaluate(experiment, Model(RIG, (), np.empty(0)), None)
    oil = [state.number for state in start_states(p, experiment)].index(H.METAL)
    assert cost(experiment, without(now.projection, oil), now) > 5.0
    assert mean_cost([now]) < 1.1


def test_an_electric_drive_has_no_seal() -> None:
    rig = load_rig("force_axis").rig
    p = Model(rig, (), np.empty(0)).vector()
    assert forms_of_friction(p) == []


def test_every_hydraulic_joint_with_friction_has_its_form() -> None:
    p = Model(RIG, (), np.empty(0)).vector()
    assert len(forms_of_friction(p)) == 2 * len({J.BRISTLE_STIFFNESS, J.BRISTLE_DAMPING, J.BRISTLE_FADE, J.STICTION, J.STRIBECK})


@pytest.mark.parametrize(("pressed", "difference"), [(0.0, 0.0), (0.54, 0.0), (0.0, 130.0), (0.3, -60.0)])
def test_a_joint_breaks_away_at_the_level_of_the_plant_under_the_pressure_that_moves_it(pressed: float, difference: float) -> None:
    """In the direction in which its friction is larger; the pressure from one level to the next."""
    p = Model(RIG, (), np.empty(0)).vector()
    p[J_START + J.PRESSURE_FRICTION] = pressed * p[J_START + J.AREA_A]
    p[J_START + J.COULOMB_DIFFERENCE] = difference
    slow, level = float(np.copysign(1e-9, difference)), 0.0
    for _ in range(200):
        pressure = level / float(p[J_START + J.AREA_A])
        level = sliding_level(slow, pressure, float(p[J_START + J.COULOMB]), faded(slow, float(p[J_START + J.BRISTLE_FADE])), p, J_START)
    assert breaking_away(p, J_START) == pytest.approx(level, rel=1e-9)
