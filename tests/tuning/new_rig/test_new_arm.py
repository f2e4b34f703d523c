"""An arm with a flexible link from data sheets: its numbers by closed forms, its servo on its own plant stepping in time."""

from __future__ import annotations

import datetime
import json
from math import pi
from pathlib import Path

import numpy as np
import pytest

from config.checking.check import check_rig
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.cli.main import main
from recording.files.reader import read_log
from servo_control.link.link_mode import LinkFrequency
from sim_backend.plant import SimulatedRig
from tuning.experiments.release import ReleaseConditions, release
from tuning.linear.closed_loop import Servo
from tuning.loop_design.arm_design import arm_problem
from tuning.loop_design.lag_lead_design import search
from tuning.loop_design.workspace import places_in

INCH_M = 0.0254
ARM = [
    "--kind", "arm", "--displacement", "10 in^3/rad", "--angle", "180 deg", "--bore", "2 in", "--rod", "1 in", "--shortest", "12 in",
    "--longest", "60 in", "--tube-outside", "1 in", "--tube-inside", "0.6 in", "--tube-length", "1.8 m", "--hub-inertia", "11.7 kg*m^2",
    "--carriage", "11.3 kg", "--payload", "45 lb", "--rotary-flow", "15 gpm", "--prismatic-flow", "10 gpm", "--rated-drop", "1000 psi",
    "--supply", "2000 psi", "--dead-volume", "200 cm^3",
]  # fmt: skip
SLENDER = [
    "--kind", "arm", "--displacement", "60 cm^3/rad", "--angle", "120 deg", "--bore", "32 mm", "--rod", "18 mm", "--shortest", "0.6 m",
    "--longest", "2.2 m", "--tube-outside", "40 mm", "--tube-inside", "34 mm", "--tube-length", "2.6 m", "--tube-material", "aluminium",
    "--hub-inertia", "3 kg*m^2", "--carriage", "4 kg", "--payload", "5 kg", "--rotary-flow", "8 l/min", "--prismatic-flow", "6 l/min",
    "--supply", "100 bar",
]  # fmt: skip
ARMS = pytest.mark.parametrize("flags", [ARM, SLENDER], ids=["the paper's", "slender aluminium"])
FRICTION = ("effect: coulomb_friction,", "effect: stiction,")


def made(folder: Path, flags: list[str]) -> LoadedRig:
    assert main(["new-rig", "boom", *flags, "-o", str(folder / "boom")]) == 0
    return load_rig(folder / "boom" / "boom.yaml")


def test_tube_and_masses_are_those_of_the_paper(tmp_path: Path) -> None:
    """A steel tube of 1.0 / 0.6 in: EI = 200 GPa π/64 (D⁴ − d⁴), 7850 kg/m³ of wall."""
    rig = made(tmp_path, ARM).rig
    assert rig.plant is not None
    assert rig.plant.link is not None
    assert rig.link_mode is not None
    assert rig.link_mode.bending_stiffness_N_m2 == pytest.approx(200e9 * pi / 64 * (1 - 0.6**4) * INCH_M**4, rel=1e-5)
    assert rig.plant.link.mass_per_length_kg_per_m == pytest.approx(7850 * pi / 4 * (1 - 0.6**2) * INCH_M**2, rel=1e-5)
    assert rig.plant.link.payload_kg == pytest.approx(45 * 0.45359237)
    assert rig.plant.joints["prismatic"].travel == pytest.approx((12 * INCH_M, 60 * INCH_M))


def test_a_deflection_sensor_is_written_where_its_range_is_given(tmp_path: Path) -> None:
    """A tube of EI = 3556.75 N m² whose payload of 20.4 kg is shaken bends: the sensor reads it in its steps, and ends at its range."""
    assert "tip.deflection" not in made(tmp_path / "without", ARM).text
    rig = made(tmp_path, [*ARM, "--deflection-range", "50 mm", "--deflection-noise", "0.1 mm"]).rig
    assert rig.plant is not None
    sensor, signal = rig.plant.sensors["tip.deflection"], rig.signals["tip.deflection"]
    assert (sensor.low, sensor.high, sensor.noise, sensor.resolution) == pytest.approx((-0.05, 0.05, 1e-4, 2e-5))
    assert signal.low < sensor.low < sensor.high < signal.high
    assert not signal.required
    plant = SimulatedRig(rig)
    plant.reset([0.0, 1.0])
    read = plant.run(np.where(np.arange(2000) < 1000, 5.0, -5.0)[:, None] * np.array([1.0, 0.0]), 0.001, sense=True)
    assert np.ptp(read["raw"][:, list(rig.signals).index("tip.deflection")]) * 2e-5 > 1e-3


@pytest.mark.slow
def test_an_arm_is_designed_for_over_its_own_workspace(tmp_path: Path) -> None:
    """0.6 to 2.2 m and 5 kg: margins and damping of the gain found hold for every place of it, and a released arm comes to rest there
    with this gain and swings with three times the gain at which the linear arm loses its damping."""
    rig = made(tmp_path, SLENDER).rig
    low, high = rig.joints["prismatic"].travel
    where = places_in(rig)
    assert min(place[0] for place in where) == pytest.approx(low)
    assert max(place[0] for place in where) == pytest.approx(high)
    assert {round(place[1], 3) for place in where} == {0.0, 5.0, 8.333}
    problem = arm_problem(rig, 0.0)
    found = search(problem, with_sections=False, effort=3)
    assert found.worst.gain_margin_dB >= 6.0
    assert found.worst.sensitivity_peak == pytest.approx(1.7, abs=0.03)
    assert found.least_damping is not None
    assert found.least_damping >= problem.least_damping
    assert problem.damping is not None
    lost = next(gain for gain in found.servo.gain * np.geomspace(1.0, 10.0, 30) if problem.damping(Servo(gain)) < 0.0)
    for extension in (low, high):
        assert not release(rig, ReleaseConditions(extension, 0.0), found.servo, 6.0).oscillates
    assert release(rig, ReleaseConditions(high, 0.0), Servo(3.0 * lost), 6.0).oscillates
    loaded = release(rig, ReleaseConditions(high, 5.0), found.servo, 10.0).deflection_m  # rings for long, 0.5 % of damping at 2.4 Hz
    assert np.ptp(loaded[-1000:]) < 0.8 * np.ptp(loaded[2000:3000])


@pytest.mark.slow
@ARMS
def test_the_files_pass_check_and_every_maneuver_runs(tmp_path: Path, flags: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    both = ["--chamber-pressures", "--deflection-range", "100 mm"]
    assert main(["new-rig", "boom", *flags, *both, "-o", str(tmp_path / "boom"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["findings"] == []
    loaded = load_rig(tmp_path / "boom" / "boom.yaml")
    assert loaded.rig.end_point is not None
    assert {finding.level for finding in check_rig(loaded, datetime.date(2026, 1, 1))} == {"ok"}
    maneuvers = [Path(path) for path in said["written"][1:]]
    assert {path.stem.removeprefix("boom_").rsplit("_", 1)[0] for path in maneuvers} >= {"joint", "line", "slow_triangle", "fast_strokes"}
    for maneuver in maneuvers:
        log = tmp_path / f"{maneuver.stem}.mcap"
        assert main(["simulate", str(tmp_path / "boom" / "boom.yaml"), str(maneuver), "-o", str(log)]) == 0, maneuver
        columns = read_log(log).columns
        for joint, limits in loaded.rig.joints.items():
            late = abs(columns[f"{joint}.position"][-1] - columns[f"{joint}.reference"][-1])
            assert late < 0.002 * (limits.travel[1] - limits.travel[0]), (maneuver, joint)


@ARMS
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_the_servo_damps_the_link_on_its_own_plant(tmp_path: Path, flags: list[str], share: float) -> None:
    """Both joints held by their gains alone, without the friction that would help; a knock of the hub's command bends the link, and it
    swings out. The loop's edge is further away: with 1.9 times the gain it still does."""
    text = made(tmp_path, flags).text
    rig = rig_from_text("".join(line for line in text.splitlines(keepends=True) if not any(word in line for word in FRICTION)))
    low, high = rig.joints["prismatic"].travel
    place = np.array([0.0, low + share * (high - low)])
    gains = np.array([rig.servo[joint].gain for joint in rig.joints])
    for factor in (1.0, 1.9):
        plant = SimulatedRig(rig)
        plant.reset(list(place))
        tip = np.empty(12_000)
        for cycle in range(len(tip)):
            knock = np.array([0.5 if cycle < 100 else 0.0, 0.0])
            plant.advance(list(factor * gains * (place - np.array(plant.true_position)) + knock), 0.001)
            tip[cycle] = plant.true_signal("tip.deflection")
        early, late = (np.ptp(part) for part in (tip[1000:3000], tip[-2000:]))
        assert early > 1e-5
        assert late < 0.75 * early


@pytest.mark.slow
@ARMS
@pytest.mark.parametrize(("share", "payload"), [(0.25, 1.0), (0.5, 0.0), (0.5, 1.0), (1.0, 1.0), (1.0, 1.5)])
def test_its_end_point_feedback_damps_the_link_where_the_payload_is_another(
    tmp_path: Path, flags: list[str], share: float, payload: float
) -> None:
    """Equation C5 (docs/method/control.md) written out, on the whole plant without dry friction and with 20 % more valve gain. The arm
    swings out; by far sooner where it has the stated payload or more. The schedule believes in the stated payload all the time."""
    text = made(tmp_path, [*flags, "--deflection-range", "100 mm"]).text
    rig = rig_from_text("".join(line for line in text.splitlines(keepends=True) if not any(word in line for word in FRICTION)))
    assert rig.end_point is not None
    assert rig.link_mode is not None
    assert rig.plant is not None
    assert rig.plant.link is not None
    link = rig.plant.link.model_copy(update={"payload_kg": payload * rig.plant.link.payload_kg})
    other = rig.model_copy(update={"plant": rig.plant.model_copy(update={"link": link})})
    low, high = rig.joints["prismatic"].travel
    place = np.array([0.0, low + share * (high - low)])
    frequency_Hz = LinkFrequency(rig.link_mode).frequency_Hz(place[1])
    heard = np.clip((rig.end_point.off_above_Hz - frequency_Hz) / (rig.end_point.off_above_Hz - rig.end_point.full_below_Hz), 0.0, 1.0)
    left = {}
    for feedback in (0.0, rig.end_point.gain * float(heard)):
        plant, filtered = SimulatedRig(other), 0.0
        plant.reset(list(place))
        tip = np.empty(5_000)
        for cycle in range(len(tip)):
            tip[cycle] = plant.true_signal("tip.deflection")
            filtered += (1.0 - np.exp(-2.0 * pi * rig.end_point.roll_off_Hz * 0.001)) * (tip[cycle] - filtered)
            error = place - np.array(plant.true_position) + np.array([feedback * filtered / place[1], 0.0])
            gains = 1.2 * np.array([rig.servo[joint].gain for joint in rig.joints])
            knock = np.array([0.5 if cycle < 100 else 0.0, 0.0])
            plant.advance(list(gains * error + knock), 0.001)
        left[feedback > 0.0] = np.ptp(tip[-1000:]) / np.ptp(tip[500:2000])
    assert left[True] < 0.75
    if payload >= 1.0:
        assert left[True] < 0.6 * left[False]


def test_without_a_sensor_or_with_a_link_that_is_too_fast_the_feedback_is_left_out_with_a_sentence(tmp_path: Path) -> None:
    without = made(tmp_path / "without", ARM)
    assert without.rig.end_point is None
    assert "`longreach new-rig --deflection-range` makes the section" in without.text
    stiff = [*SLENDER, "--tube-outside", "120 mm", "--tube-inside", "60 mm", "--deflection-range", "50 mm"]
    fast = made(tmp_path / "fast", stiff)
    assert fast.rig.end_point is None
    assert "it would not damp the link" in fast.text


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (("--tube-inside", "1.2 in"), "no wall is left"),
        (("--shortest", "70 in"), "no range of an extension"),
        (("--tube-material", "wood"), "Give one of steel, aluminium"),
        (("--payload", "45"), "--payload '45': a unit is missing"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(
    change: tuple[str, str], text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flags = list(ARM)
    if change[0] in flags:
        flags[flags.index(change[0]) + 1] = change[1]
    else:
        flags += change
    assert main(["new-rig", "boom", *flags, "-o", str(tmp_path / "boom")]) == 2
    assert text in capsys.readouterr().err
    assert not (tmp_path / "boom").exists()
