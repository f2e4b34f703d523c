"""A rig file from data sheets: its numbers against closed forms and its own simulated plant, its servo against python-control."""

from __future__ import annotations

import datetime
import json
from math import pi, sqrt
from pathlib import Path

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from config.checking.check import check_rig
from config.loading.load import load_rig, rig_from_text
from config.oil_grades import GRADES, walther_constants
from config.parsing.provenance import tag_of
from config.parsing.yaml_tree import parse
from daemon.cli.main import main
from recording.files.reader import read_log
from sim_backend.plant import SimulatedRig
from tuning.new_rig.axis import Axis

CYLINDER = [
    "--kind", "cylinder", "--bore", "16 mm", "--rod", "10 mm", "--stroke", "200 mm", "--mass", "8 kg", "--rated-flow", "10 l/min",
    "--supply", "70 bar", "--resolution", "5 um", "--noise", "5 um",
]  # fmt: skip
ROTARY = [
    "--kind", "rotary", "--displacement", "10 in^3/rad", "--angle", "180 deg", "--inertia", "40 kg*m^2", "--rated-flow", "15 gpm",
    "--rated-drop", "1000 psi", "--supply", "2000 psi", "--resolution", "0.005 deg", "--noise", "0.002 deg", "--iso-vg", "ISO VG 32",
]  # fmt: skip


def cylinder(bore: float = 0.016, rod: float = 0.010, stroke: float = 0.2, mass: float = 5.0, flow: float = 10e-3 / 60) -> Axis:
    area = pi / 4 * bore**2
    rest = area - pi / 4 * rod**2
    return Axis(False, area, rest, 0.0, stroke, mass, 20e-6, flow, 70e5, 10.0, 0.01, 70e5, 5e-6, 5e-6)


@pytest.mark.parametrize("command_V", [10.0, -10.0])
def test_full_speed_is_what_the_simulated_cylinder_reaches(tmp_path: Path, command_V: float) -> None:
    """Without friction, at constant full command; the return line's 2 bar take 1.5 %."""
    assert main(["new-rig", "bench", *CYLINDER, "-o", str(tmp_path / "bench")]) == 0
    text = load_rig(tmp_path / "bench" / "bench.yaml").text
    ideal = "".join(line for line in text.splitlines(keepends=True) if "_friction," not in line and "effect: stiction" not in line)
    plant = SimulatedRig(rig_from_text(ideal))
    plant.reset([0.02 if command_V > 0 else 0.18])
    run = plant.run(np.full((120, 1), command_V), 0.001)
    speed = abs(run["axis.position"][100] - run["axis.position"][60]) / 0.04
    out, back = cylinder().speeds
    assert speed == pytest.approx(out if command_V > 0 else back, rel=0.03)


def test_speeds_of_equal_areas_are_the_textbooks() -> None:
    """Half the supply over each land: v = Q_rated sqrt(supply / rated drop) / A."""
    axis = cylinder(rod=0.0)
    expected = 10e-3 / 60 * sqrt(70e5 / 70e5) / axis.area_a
    assert axis.speeds == pytest.approx((expected, expected))


@settings(max_examples=60)
@given(
    bore=some.floats(0.01, 0.2), slim=some.floats(0.2, 0.8), stroke=some.floats(0.05, 2.0), mass=some.floats(0.5, 5e3),
    flow=some.floats(2e-5, 5e-3),
)  # fmt: skip
def test_the_servo_is_stable_with_margins_on_its_own_numbers(bore: float, slim: float, stroke: float, mass: float, flow: float) -> None:
    """Integrator, oil resonance with the least damping assumed, valve of second order, one and a half cycles of delay: python-control."""
    axis = cylinder(bore, slim * bore, stroke, mass, flow)
    s = control.tf("s")
    w, valve = axis.natural_frequency_rad_s, 4.0 / axis.stroke_time_s
    loop = axis.loop_gain_1_s / s / (s**2 / w**2 + 0.2 * s / w + 1) / (s**2 / valve**2 + 1.6 * s / valve + 1)
    delay = control.tf(*control.pade(0.0015, 3))
    gain_margin, phase_margin, _, _ = control.margin(loop * delay)
    assert gain_margin > 1.5
    assert phase_margin > 45


@pytest.mark.parametrize("flags", [CYLINDER, ROTARY], ids=["cylinder", "rotary"])
def test_the_files_pass_check_and_the_simulated_axis_runs_them(
    tmp_path: Path, flags: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "bench"
    assert main(["new-rig", "bench", *flags, "--chamber-pressures", "-o", str(folder), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["findings"] == []
    loaded = load_rig(folder / "bench.yaml")
    assert {finding.level for finding in check_rig(loaded, datetime.date(2026, 1, 1))} == {"ok"}
    log = tmp_path / "steps.mcap"
    assert main(["simulate", str(folder / "bench.yaml"), str(folder / "bench_joint_steps.yaml"), "-o", str(log)]) == 0
    columns = read_log(log).columns
    travel = loaded.rig.joints["axis"].travel
    assert abs(columns["axis.position"][-1] - columns["axis.reference"][-1]) < 0.002 * (travel[1] - travel[0])


@pytest.mark.parametrize("given", [[], ["--stroke-time", "10 ms", "--rated-drop", "70 bar", "--full-scale", "10 V", "--iso-vg", "46"]])
def test_what_was_not_given_is_tagged_as_assumed(tmp_path: Path, given: list[str]) -> None:
    """A search trusts a data sheet's number to 3 %, an assumed one to a quarter."""
    assert main(["new-rig", "bench", *CYLINDER, *given, "-o", str(tmp_path / "bench")]) == 0
    tree = parse(load_rig(tmp_path / "bench" / "bench.yaml").text, "bench.yaml")
    plant, valve = ("plant", "joints", "axis"), ("plant", "joints", "axis", "valve")
    asked = [(*valve, "stroke_time"), (*valve, "rated_pressure_drop"), (*valve, "full_scale"), ("plant", "oil", "iso_vg")]
    assert {tag_of(tree, path) for path in asked} == {"DS" if given else "A"}
    assert {tag_of(tree, (*plant, key)) for key in ("bore", "rod", "mass")} == {tag_of(tree, (*valve, "rated_flow"))} == {"DS"}


def test_questions_are_asked_again_until_they_can_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sizes = ["cilinder", "cylinder", "", "16", "16 mm", "20 mm", "10 mm", "200 mm", "5 kg"]
    replies = iter([*sizes, "", "ten", "10 l/min", "", "", "", "70", "70 bar", "", "5 um", "5 um"])
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("builtins.input", lambda text: next(replies))
    assert main(["new-rig", "asked", "-o", str(tmp_path / "asked")]) == 0
    assert load_rig(tmp_path / "asked" / "asked.yaml").rig.plant is not None
    assert next(replies, None) is None
    told = [line.strip() for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert told[:5] == [
        "'cilinder' is none of them: nearest is 'cylinder'",
        "'16': a unit is missing. Write it with one, e.g. '16 mm'",
        "'20 mm': must be thinner than the bore, 16 mm",
        "'ten': a unit is missing. Write it with one, e.g. '10 l/min'",
        "'70': a unit is missing. Write it with one, e.g. '70 bar'",
    ]


def test_what_is_missing_or_wrong_is_told_at_once_and_nothing_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = ["--bore", "16", "--rod", "10 mm", "--stroke", "3 kg"]
    assert main(["new-rig", "bench", "--kind", "cylinder", *wrong, "-o", str(tmp_path / "bench")]) == 2
    said = capsys.readouterr().err
    for part in ("--bore '16': a unit is missing", "--stroke '3 kg': wrong kind of unit", "--mass is missing", "--supply is missing"):
        assert part in said
    assert main(["new-rig", "bench", *CYLINDER, "--iso-vg", "47", "-o", str(tmp_path / "bench")]) == 2
    assert "iso_vg 47 is none of 10, 15, 22, 32, 46" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("name", "better"), [("Prüfstand 1", "prufstand_1"), ("2nd rig", "nd_rig"), ("Ä", "a"), ("§", "my_rig")])
def test_a_name_that_no_rig_can_have_is_told_first_with_one_that_it_can(
    name: str, better: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["new-rig", name, *CYLINDER, "-o", str(tmp_path / "rig")]) != 0
    said = capsys.readouterr().err
    assert name in said
    assert f"longreach new-rig {better}" in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "flag", ["bore", "stroke", "mass", "rated-flow", "rated-drop", "supply", "full-scale", "stroke-time", "resolution"]
)
def test_a_size_of_nothing_or_beyond_any_machine_is_told_with_its_flag(
    tmp_path: Path, flag: str, capsys: pytest.CaptureFixture[str]
) -> None:
    unit = {"mass": "kg", "rated-flow": "l/min", "rated-drop": "bar", "supply": "bar", "full-scale": "V", "stroke-time": "s"}.get(
        flag, "mm"
    )
    for size, said in (("0", "must be above 0"), ("-1", "must not be negative. Give its size"), ("1e300", "no machine has that")):
        assert main(["new-rig", "bench", *CYLINDER, f"--{flag}={size} {unit}", "-o", str(tmp_path / "bench")]) == 2
        assert f"--{flag} '{size} {unit}': {said}. Give them with units" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("grade", GRADES)
def test_a_grade_of_oil_has_its_viscosity_at_40_degrees(grade: int) -> None:
    a, b = walther_constants(float(grade), GRADES[grade])
    viscosity = [10.0 ** (10.0 ** (a - b * np.log10(celsius + 273.15))) - 0.7 for celsius in (40.0, 100.0)]
    assert viscosity == pytest.approx([grade, GRADES[grade]], rel=1e-9)
