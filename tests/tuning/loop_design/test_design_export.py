"""`design --export`: the closed loop rebuilt from the .mat file has the margins and the damping that were printed."""

from __future__ import annotations

import json
from math import degrees, pi
from pathlib import Path

import control
import numpy as np
import pytest
from scipy.io import loadmat

from config.errors import LogError, UsageError
from config.schema.rig import Rig
from daemon.cli.main import main
from tuning.linear.closed_loop import Servo
from tuning.loop_design.arm_design import ArmDesign, arm_problem
from tuning.loop_design.design_export import check_export_path, design_systems, read_design, write_design
from tuning.loop_design.lag_lead_design import evaluate

SERVO = Servo(degrees(0.9), ((60.0, 600.0), (8.0, 2.0)), 0.75, 8.0)


@pytest.fixture(scope="module")
def found(rig: Rig) -> ArmDesign:
    problem = arm_problem(rig, SERVO.tip_gain)
    chosen = evaluate(problem, SERVO)
    return ArmDesign(problem, chosen, chosen, chosen, ())


def _system(fields: dict) -> control.StateSpace:
    rows = np.size(fields["outputs"])
    states = len(fields["A"])
    b, c = np.reshape(fields["B"], (states, 1)), np.reshape(fields["C"], (rows, states))
    return control.ss(fields["A"], b, c, np.zeros((rows, 1)))


def _margins(response: np.ndarray, omega: np.ndarray) -> tuple[float, float, float]:
    gain, phase, distance, *_ = control.stability_margins(control.frd(response, omega, smooth=True), returnall=True)
    return 20 * np.log10(gain[gain > 1].min()), np.abs(phase).min(), 1 / distance.min()


def _least_damping(content: dict) -> float:
    period_s = content["sample_time_s"]
    sampled, low_pass = (control.tf(content[name]["num"], content[name]["den"], period_s) for name in ("sampled_compensator", "tip_filter"))
    found = []
    for place in content["flexible"]:
        kept, lead = place["tip_lead"]
        tip = content["tip_gain"] * place["tip_share"] / place["extension_m"] * ((kept - lead) * low_pass + lead)
        one = control.ss([], [], [], 1.0, period_s)
        error = control.ss([], [], [], [[-1.0, 1.0]], period_s) * control.append(one, control.ss(tip))
        for factor in content["gain_factors"]:
            loop = control.feedback(control.c2d(_system(place), period_s), factor * control.ss(sampled) * error, 1)
            with np.errstate(divide="ignore", invalid="ignore"):
                frequency, damping, _ = loop.damp()
            least = damping[np.isfinite(frequency) & (frequency > 1e-6)].min()
            if not (place["light"] and least > content["light_damping"]):
                found.append(least)
    return min(found)


@pytest.mark.slow
def test_the_loop_rebuilt_from_the_file_is_the_one_that_was_printed(rig: Rig, found: ArmDesign, tmp_path: Path) -> None:
    path = tmp_path / "design.mat"
    write_design(design_systems(rig, found), path)
    content = loadmat(path, simplify_cells=True)
    compensator = control.tf(content["compensator"]["num"], content["compensator"]["den"])
    omega = 2 * pi * np.geomspace(0.05, 100.0, 800)
    late = compensator(1j * omega) * np.exp(-1j * omega * content["dead_time_s"])
    margins = [
        _margins(factor * late * _system(plant)(1j * omega), omega) for plant in content["rigid"] for factor in content["gain_factors"]
    ]
    for item in content["amplitudes"]:
        omega = item["omega_rad_per_s"]
        margins.append(_margins(compensator(1j * omega) * item["response"], omega))
    worst = found.chosen.worst
    gain, phase, peak = np.array(margins).T
    assert gain.min() == pytest.approx(worst.gain_margin_dB, abs=1e-3)
    assert phase.min() == pytest.approx(worst.phase_margin_deg, abs=1e-2)
    assert peak.max() == pytest.approx(worst.sensitivity_peak, abs=1e-3)
    assert _least_damping(content) == pytest.approx(found.chosen.least_damping, abs=1e-8)


def test_names_units_and_operating_points(rig: Rig, found: ArmDesign, tmp_path: Path) -> None:
    path = tmp_path / "design.mat"
    write_design(design_systems(rig, found), path)
    content = loadmat(path, simplify_cells=True)
    first, last = content["flexible"][0], content["flexible"][-1]
    assert len(content["flexible"]) == 12
    assert (first["extension_m"], first["payload_kg"]) == pytest.approx((12 * 0.0254, 0.0))
    assert (last["extension_m"], last["payload_kg"]) == pytest.approx((60 * 0.0254, 75 * 0.45359237))
    assert list(last["inputs"]) == ["rotary_command_V"] or last["inputs"] == "rotary_command_V"
    assert list(last["outputs"]) == ["rotary_position_rad", "tip_deflection_m"]
    assert len(last["states"]) == len(last["A"]) == 10
    # position is the integral of velocity and deflection that of its rate, as the names say
    rows = dict(zip(last["states"], last["A"], strict=True))
    velocity, rate = (list(last["states"]).index(name) for name in ("rotary_velocity_rad_per_s", "tip_deflection_rate_m_per_s"))
    assert rows["rotary_position_rad"] == pytest.approx(np.eye(10)[velocity], abs=1e-6)
    assert rows["tip_deflection_m"] == pytest.approx(np.eye(10)[rate], abs=1e-6)
    assert content["sample_time_s"] == pytest.approx(1.0 / rig.loop.rate_Hz)
    assert content["compensator"]["sample_time_s"] == 0.0


def test_what_is_read_is_what_was_written(rig: Rig, found: ArmDesign, tmp_path: Path) -> None:
    path = tmp_path / "design.mat"
    design = design_systems(rig, found)
    write_design(design, path)
    read = read_design(path)
    assert list(tmp_path.iterdir()) == [path]
    assert (read.rig, read.tip_gain, read.gain_factors) == (rig.name, 0.75, (0.8, 1.0, 1.2))
    s, z = 2j * pi * np.array([0.3, 3.0, 30.0]), np.exp(0.002j * pi * np.array([0.3, 3.0, 30.0]))
    assert read.compensator(s) == pytest.approx(design.compensator(s))
    assert read.sampled_compensator.dt == 0.001
    assert read.sampled_compensator(z) == pytest.approx(design.sampled_compensator(z))
    for one, other in zip((*read.flexible, *read.rigid), (*design.flexible, *design.rigid), strict=True):
        assert np.array_equal(one.system.A, other.system.A)
        assert one.system.state_labels == other.system.state_labels
        assert (one.tip_lead, one.light) == (other.tip_lead, other.light)
    assert read.amplitudes[0][0] == 0.1


def test_a_bad_path_is_refused_before_the_search(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no folder"):
        check_export_path(tmp_path / "nowhere" / "design.mat")


def test_the_command_refuses_a_bad_path_at_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "ornl_testbed", "--export", str(tmp_path / "nowhere" / "design.mat"), "--json"]) == 2
    assert "no folder" in json.loads(capsys.readouterr().out)["error"]["text"]


def test_an_old_file_stays_when_writing_fails(rig: Rig, found: ArmDesign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "design.mat"
    path.write_bytes(b"old")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tuning.loop_design.design_export.savemat", full)
    with pytest.raises(LogError, match="No space left"):
        write_design(design_systems(rig, found), path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "design.mat"
    path.write_bytes(b"no MATLAB file at all")
    with pytest.raises(LogError, match="no exported design"):
        read_design(path)
