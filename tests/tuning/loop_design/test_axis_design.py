"""A servo for a single hydraulic axis: margins over the stroke, and the axis stepping in time with it."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import control
import numpy as np
import pytest

from config.loading.load import load_rig
from config.schema.rig import Rig
from daemon.cli.main import main
from servo_control.servo.servo import JointServo
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.linear.closed_loop import Servo
from tuning.loop_design.arm_design import ArmDesign, as_overrides, hunting
from tuning.loop_design.axis_design import axis_joint, axis_places, axis_problem, worst_axis_damping
from tuning.loop_design.design_export import design_systems, read_design, write_design
from tuning.loop_design.lag_lead_design import evaluate, search


@pytest.fixture(scope="module")
def axis() -> Rig:
    return load_rig("analogue_axis").rig


def _sliding(rig: Rig, gain: float) -> Floats:
    """Position less reference over a second in which the axis slides at 20 mm/s, after half a second of the same."""
    plant, period_s = SimulatedRig(rig), 1.0 / rig.loop.rate_Hz
    servo = JointServo(rig.joints["axis"], rig.servo["axis"].model_copy(update={"gain": gain}), period_s)
    plant.reset([0.15])
    errors = []
    for cycle in range(1500):
        reference = 0.15 + 0.02 * cycle * period_s
        (position,) = plant.true_position
        servo.measure(position)
        servo.step(reference, 0.02, 0.0)
        errors.append(position - reference)
        plant.advance([servo.command_V], period_s)
    return np.array(errors[500:])


def test_gain_found_keeps_its_margins_and_slides_quietly(axis: Rig) -> None:
    """Six times the gain at which the linear loop loses its damping shakes the axis: friction, left out, cannot help while it slides."""
    problem = axis_problem(axis)
    found = search(problem, with_sections=False, effort=3)
    assert found.worst.gain_margin_dB >= 6.0
    assert found.worst.phase_margin_deg >= 45.0
    assert found.least_damping is not None
    assert found.least_damping > 0.0
    assert problem.damping is not None
    lost = next(gain for gain in found.servo.gain * np.geomspace(1.0, 30.0, 60) if problem.damping(Servo(gain)) < 0.0)
    assert np.ptp(_sliding(axis, found.servo.gain)[-300:]) < 0.1e-3
    assert np.ptp(_sliding(axis, 2.0 * lost)[-300:]) > 1e-3


def test_overrides_are_of_the_axis_and_its_unit(axis: Rig) -> None:
    assert as_overrides(axis, Servo(400.0)) == ["servo.axis.gain=400 V/m", "servo.axis.sections=[]"]


@pytest.mark.slow
def test_command_writes_a_rig_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, picture, export = tmp_path / "axis.yaml", tmp_path / "design.png", tmp_path / "design.mat"
    words = ["--picture", str(picture), "--export", str(export), "--largest-cycle", "0.2", "-o", str(out)]
    assert main(["design", "analogue_axis", "--effort", "2", "--json", *words]) == 0
    found = json.loads(capsys.readouterr().out)
    assert load_rig(out).rig.servo["axis"].gain == pytest.approx(found["chosen"]["servo"]["gain"], rel=1e-5)
    assert found["chosen"]["worst"]["gain_margin_dB"] >= 5.99
    assert read_design(export).compensator(0.0) == pytest.approx(found["chosen"]["servo"]["gain"])
    assert all(cycle is None or cycle["load_amplitude"] <= 0.2 for cycle in found["hunting"])
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_the_family_slides_with_friction_and_is_damped_where_it_is_held(axis: Rig) -> None:
    """Three places, four openings and rest: margins where it slides, damping of the sampled loop everywhere."""
    places, problem = axis_places(axis), axis_problem(axis)
    assert [place.held for place in places].count(True) == 3
    assert len(problem.plants) == 3 * (len(places) - 3)
    held = [place.arm for place in places if place.held]
    assert problem.damping is not None
    assert problem.damping(Servo(400.0)) == min(worst_axis_damping([place.arm], 1e-3, Servo(400.0)) for place in places)
    assert worst_axis_damping(held, 1e-3, Servo(400.0)) > problem.damping(Servo(400.0)), "friction holds it there"


def test_hunting_is_that_of_the_axis_between_friction_and_lag(axis: Rig) -> None:
    """A gain that the axis bears leaves it at rest, whatever its stiction; much lag makes it hunt, as it does the paper's arm."""
    joint = axis_joint(axis)
    assert hunting(joint, Servo(347.9)) == (None, None, None)
    lagged = hunting(joint, Servo(1856.0, ((24.04, 5.387),)))
    assert all(cycle is not None and 1.0 < cycle.frequency_Hz < 3.0 for cycle in lagged)
    assert all(cycle is not None and cycle.load_amplitude < 0.5 for cycle in lagged)


def test_the_loop_rebuilt_from_the_export_is_the_one_that_was_judged(axis: Rig, tmp_path: Path) -> None:
    servo = Servo(1200.0, ((24.0, 8.0),))
    problem = axis_problem(axis)
    chosen = evaluate(problem, servo)
    path = tmp_path / "design.mat"
    write_design(design_systems(axis, ArmDesign(problem, chosen, chosen, chosen, ())), path)
    read = read_design(path)
    assert (len(read.flexible), len(read.rigid), read.delay_periods) == (15, 12, 1)
    system = read.flexible[0].system
    spool_and_oil = ["spool", "spool_rate_per_s", "pressure_A_Pa", "pressure_B_Pa"]
    assert system.state_labels == ["axis_position_m", "axis_velocity_m_per_s", *spool_and_oil, "bristle_m"]
    assert (system.input_labels, system.output_labels) == (["axis_command_V"], ["axis_position_m"])
    least = []
    late = control.tf([1.0], [1.0, 0.0], read.sample_time_s) ** read.delay_periods
    for place, gain in product(read.flexible, read.gain_factors):
        held = control.c2d(place.system, read.sample_time_s)
        loop = control.feedback(gain * held * control.ss(read.sampled_compensator * late))
        with np.errstate(divide="ignore", invalid="ignore"):
            frequency, damping, _ = loop.damp()
        least.append(damping[np.isfinite(frequency) & (frequency > 1e-6)].min())
    assert min(least) == pytest.approx(chosen.least_damping, abs=1e-6)
    omega = 2 * np.pi * np.geomspace(0.05, 100.0, 2000)
    dead = np.exp(-1j * omega * read.dead_time_s) * read.compensator(1j * omega)
    peaks = [np.max(1 / np.abs(1 + gain * dead * plant.system(1j * omega))) for plant, gain in product(read.rigid, read.gain_factors)]
    assert max(peaks) == pytest.approx(chosen.worst.sensitivity_peak, rel=1e-2)


@pytest.mark.parametrize("option", [["--schedule"], ["--tip-gain", "0.5"]])
def test_what_only_an_arm_has_is_refused(option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "analogue_axis", *option]) != 0
    assert f"a single axis has no link: {option[0]}" in capsys.readouterr().err
