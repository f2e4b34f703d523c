"""A servo for a single hydraulic axis: margins over the stroke, and the axis stepping in time with it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig
from config.schema.rig import Rig
from daemon.cli.main import main
from servo_control.servo.servo import JointServo
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.linear.closed_loop import Servo
from tuning.loop_design.arm_design import as_overrides
from tuning.loop_design.axis_design import axis_problem
from tuning.loop_design.lag_lead_design import search


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
    out, picture = tmp_path / "axis.yaml", tmp_path / "design.png"
    assert main(["design", "analogue_axis", "--effort", "2", "--json", "--picture", str(picture), "-o", str(out)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert load_rig(out).rig.servo["axis"].gain == pytest.approx(found["chosen"]["servo"]["gain"], rel=1e-5)
    assert found["chosen"]["worst"]["gain_margin_dB"] >= 5.99
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("option", [["--schedule"], ["--tip-gain", "0.5"], ["--export", "design.mat"], ["--largest-cycle", "0.1"]])
def test_what_only_an_arm_has_is_refused(option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "analogue_axis", *option]) != 0
    assert f"a single axis has no link: {option[0]}" in capsys.readouterr().err
