"""`commission` on a copy of a rig file, in lockstep: every step judges what it is for, what passed is not made twice, the page says all."""

from __future__ import annotations

import json
from math import pi, sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from config.loading.load import find, load_rig
from daemon.cli.commission.at_rest import sensors, stops
from daemon.cli.commission.bench import DaemonBench, LockstepBench
from daemon.cli.commission.context import Context
from daemon.cli.commission.identified import identification
from daemon.cli.commission.moving import polarity, stop_in_motion
from daemon.cli.commission.record import FILE, Commissioning, Outcome, record_of
from daemon.cli.commission.steps import NAMES
from daemon.cli.commission.tuned import SHAPED_MOVE, first_shaped_move, gap, servo_design
from daemon.cli.connection import OperatorClient
from daemon.cli.main import main
from recording.files.reader import read_log
from servo_control.signals import Mode
from tests.support.config.bench_rigs import DEVICES
from tests.support.static_page import opened, outside_links


def rig_copy(directory: Path, *changes: tuple[str, str]) -> Path:
    """The testbed's file under another name, as a user begins."""
    text = find("rigs", "ornl_testbed").read_text().replace("name: ornl_testbed", "name: my_rig", 1)
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    path = directory / "my_rig.yaml"
    path.write_text(text)
    return path


def made(rig: Path, step: Any, folder: Path) -> Any:
    """The outcome of one step."""
    loaded = load_rig(rig)
    with LockstepBench(loaded, folder / "logs") as bench:
        return step(Context(loaded, bench, folder, lambda question: True, lambda line: None))


def commission(capsys: pytest.CaptureFixture[str], rig: Path, *words: str, status: int = 0) -> tuple[dict[str, Any], str]:
    assert main(["commission", str(rig), "--simulated", "--yes", "--out", str(rig.parent / "out"), "--json", *words]) == status
    said = capsys.readouterr()
    answer: dict[str, Any] = json.loads(said.out)
    return answer, said.err


def test_every_way_to_stop_is_seen_at_rest_and_in_motion(tmp_path: Path) -> None:
    rig = rig_copy(tmp_path)
    rest = made(rig, stops, tmp_path)
    assert rest.passed
    assert [value.value for value in rest.values] == ["fault", "refused", "disarmed", "disarmed"]
    moving = made(rig, stop_in_motion, tmp_path)
    assert moving.passed, moving.values
    log = read_log(Path(moving.logs[0]))
    assert Mode.STOPPING in set(log.columns["mode"].tolist())
    assert Mode.FAULT not in set(log.columns["mode"].tolist())


def test_the_valves_polarity_and_gain_come_out(tmp_path: Path) -> None:
    found = made(rig_copy(tmp_path), polarity, tmp_path)
    assert found.passed, found.values
    values = {value.what: value for value in found.values}
    assert values["rotary polarity"].value == values["prismatic polarity"].value == "positive"
    assert " deg/s a volt" in values["rotary rate"].value
    per_volt = float(values["rotary rate"].value.split()[0])
    assert per_volt == pytest.approx(43.09, rel=0.15)  # small-signal gain of joint and valve, config/rigs/ornl_testbed.yaml


def test_null_friction_and_gain_of_an_axis_are_told_apart(tmp_path: Path) -> None:
    """The numbers of config/rigs/force_axis.yaml over its 35.1507 N/V: -3.16 N of offset, 20.39 N of friction, 203.5 N s/m."""
    found = made(find("rigs", "force_axis"), polarity, tmp_path)
    assert found.passed, found.values
    values = {value.what: value.value for value in found.values}
    assert float(values["axis null of the valve"].split()[0]) == pytest.approx(1e3 * 3.16 / 35.1507, rel=0.02)
    assert float(values["axis friction"].strip("±").split()[0]) == pytest.approx(1e3 * 20.39 / 35.1507, rel=0.05)
    assert float(values["axis rate"].split()[0]) == pytest.approx(35.1507 / 203.5, rel=0.1)


@pytest.mark.parametrize("step", [identification, servo_design], ids=lambda step: step.__name__)
def test_what_is_made_for_an_arm_says_so_on_an_axis_and_the_walk_goes_on(step: Any, tmp_path: Path) -> None:
    found = made(find("rigs", "force_axis"), step, tmp_path)
    assert found.passed is None
    assert "`" in found.text, "what to type instead"
    assert not list((tmp_path / "logs").glob("*.mcap")), "nothing moved"


def test_an_axis_makes_two_plain_moves_of_which_the_second_is_no_repeat(tmp_path: Path) -> None:
    rig = load_rig("force_axis").rig
    found = made(find("rigs", "force_axis"), first_shaped_move, tmp_path)
    assert found.passed, found.values
    assert [(value.what, value.value) for value in found.values] == [("fast", "valid"), ("slow", "valid")]
    assert Path(found.files[0]).exists(), "the report"
    low, high = rig.joints["axis"].travel
    fast, slow = (read_log(Path(path)).columns for path in found.logs)
    assert (np.max(fast["axis.reference"]) - low) / (high - low) == pytest.approx(0.6, abs=1e-6)
    assert (np.min(slow["axis.reference"]) - low) / (high - low) == pytest.approx(0.35, abs=1e-4)
    fastest = [np.nanmax(abs(columns["axis.target_rate"])) for columns in (fast, slow)]
    assert fastest[1] < 0.5 * fastest[0]


def _merritt() -> tuple[float, float]:
    """16/10 mm x 200 mm at mid stroke, 20 cm³ behind each chamber, 1.4 GPa: N/m of oil. 10 l/min at 70 bar and as much supply: m/s a volt,
    the mean of out and back, K √(p/(1 + r³))/A a full scale out, √r times that back (as `new-rig` writes them)."""
    a, b = pi / 4 * 0.016**2, pi / 4 * (0.016**2 - 0.010**2)
    stiffness = 1.4e9 * (a**2 / (20e-6 + a * 0.1) + b**2 / (20e-6 + b * 0.1))
    ratio, k = b / a, 10e-3 / 60 / sqrt(70e5 / 2)  # both lands share the drop
    out = k * sqrt((70e5 - 2e5) / (1 + ratio**3)) / a
    return stiffness, 0.5 * (1 + sqrt(ratio)) * out / 10.0


@pytest.mark.slow
def test_an_axis_from_data_sheets_is_commissioned_to_its_gap(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    size = ["--bore", "16 mm", "--rod", "10 mm", "--stroke", "200 mm", "--mass", "5 kg", "--rated-flow", "10 l/min", "--supply", "70 bar"]
    sensors = ["--resolution", "5 um", "--noise", "5 um", "--chamber-pressures"]
    assert main(["new-rig", "bench", "--kind", "cylinder", *size, *sensors, "-o", str(tmp_path / "bench"), "--json"]) == 0
    capsys.readouterr()
    answer, said = commission(capsys, tmp_path / "bench" / "bench.yaml", "--effort", "1")
    assert answer["failed"] is None, said
    words = {name: step["outcome"]["passed"] for name, step in answer["steps"].items()}
    assert [name for name, passed in words.items() if passed is None] == ["safe state"]
    assert list(words) == list(NAMES)
    found = {value["what"]: value["value"] for value in answer["steps"]["identification"]["outcome"]["values"]}
    stiffness, per_volt = _merritt()
    middle = next(what.removeprefix("natural frequency ") for what in found if what.startswith("natural frequency"))
    assert float(found[f"natural frequency {middle}"].split()[0]) == pytest.approx(sqrt(stiffness / 5.0) / (2 * pi), rel=0.08)
    assert float(found[f"rate a volt {middle}"].split()[0]) == pytest.approx(1e3 * per_volt, rel=0.08)
    designed = {value["what"]: value["value"] for value in answer["steps"]["design"]["outcome"]["values"]}
    assert designed["responses measured before that it keeps these margins on"] == "4"
    verdict = answer["steps"]["gap"]["outcome"]["values"]
    assert [value["value"] for value in verdict] == ["no_gap"], "the simulated rig lacks nothing"


def test_a_valve_that_is_wired_the_other_way_does_not_pass(tmp_path: Path) -> None:
    output = "channel: rotary.command\n    scale: "
    found = made(rig_copy(tmp_path, (f"{output}1.0", f"{output}-1.0")), polarity, tmp_path)
    assert found.passed is False
    assert "turn the sign of outputs.rotary.scale" in found.text


def test_a_sensor_with_a_wrong_zero_does_not_pass(tmp_path: Path) -> None:
    old = "calibration: {scale: 0.005 deg}"
    found = made(rig_copy(tmp_path, (old, "calibration: {scale: 0.005 deg, offset: 5 deg}")), sensors, tmp_path)
    assert found.passed is False
    wrong = [value for value in found.values if not value.ok]
    assert [(value.what, value.limit) for value in wrong] == [("rotary.position beside the plant", "0 deg")]
    assert wrong[0].value.startswith("5")
    assert made(rig_copy(tmp_path), sensors, tmp_path).passed


def test_what_passed_is_not_made_again_until_the_rig_file_changes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = rig_copy(tmp_path)
    first, _ = commission(capsys, rig, "--until", "sensors")
    assert list(first["steps"]) == ["rig file", "stop", "sensors"]
    second, said = commission(capsys, rig, "--until", "safe state")
    assert {name: second["steps"][name] for name in first["steps"]} == first["steps"]
    assert second["steps"]["safe state"]["outcome"]["passed"] is None
    assert "3. sensors: passed," in said
    again, said = commission(capsys, rig, "--until", "sensors", "--again", "stop")
    assert again["steps"]["rig file"] == first["steps"]["rig file"]
    assert "2. stop\n" in said
    rig.write_text(rig.read_text().replace("countdown: 3 s", "countdown: 4 s"))
    changed, said = commission(capsys, rig, "--until", "rig file")
    assert "1. rig file\n" in said
    assert changed["steps"]["rig file"]["rig_sha256"] != first["steps"]["rig file"]["rig_sha256"]


def test_a_step_that_does_not_pass_ends_the_walk_with_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = "channel: rotary.command\n    scale: "
    rig = rig_copy(tmp_path, (f"{output}1.0", f"{output}-1.0"))
    answer, _ = commission(capsys, rig, status=1)
    assert answer["failed"] == "polarity and null"
    assert list(answer["steps"]) == list(NAMES[:5])
    text = Path(answer["page"]).read_text()
    assert "not passed: polarity and null" in text
    assert "docs/guide/rig/wiring.md#4-the-first-valve" in text


def test_records_that_are_none_and_steps_that_are_none_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = rig_copy(tmp_path)
    words = ["commission", str(rig), "--simulated", "--yes", "--out", str(tmp_path / "out")]
    assert main([*words, "--until", "sensor"]) == 2
    assert "nearest is 'sensors'" in capsys.readouterr().err
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / FILE).write_text("[]")
    assert main([*words, "--list"]) == 3
    (tmp_path / "out" / FILE).write_text(json.dumps({"rig": "another", "steps": {}}))
    assert main([*words, "--list"]) == 3
    assert "of another rig" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "text", "following"),
    [
        ([], load_rig("ornl_testbed").text, "commission {rig} --out {out} --yes"),
        (["--simulated"], load_rig("ornl_testbed_can").text, "commission {rig} --simulated --out {out} --yes"),
        ([], load_rig("ornl_testbed_can").text, "commission {rig} --out {out} --simulated --yes"),
        ([], DEVICES, "commission --help"),
    ],
    ids=["simulated devices", "simulated", "real devices", "no plant"],
)
def test_nobody_to_ask_is_refused_and_yes_is_for_the_simulation_alone(
    words: list[str], text: str, following: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a rig --yes would say that the pressure is off."""
    monkeypatch.setattr("sys.stdin", (tmp_path / "empty").open("w+"))
    rig, out = tmp_path / "bench.yaml", tmp_path / "out"
    rig.write_text(text)
    assert main(["commission", str(rig), *words, "--out", str(out)]) == 2
    said = capsys.readouterr().err
    assert "nobody can be asked before motion" in said
    assert said.splitlines()[-1] == f"next: longreach {following.format(rig=rig, out=out)}"


def test_after_ctrl_c_it_says_that_the_arm_is_at_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And not that the daemon's motion goes on, which is stopped by then."""

    def interrupted(self: object, rig: object, client: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(DaemonBench, "__init__", interrupted)
    monkeypatch.setattr(OperatorClient, "__init__", lambda *_, **__: None)
    monkeypatch.setattr(OperatorClient, "__enter__", lambda client: client)
    monkeypatch.setattr(OperatorClient, "__exit__", lambda *_: None)
    assert main(["commission", str(rig_copy(tmp_path)), "--yes", "--out", str(tmp_path / "out")]) == 130
    said = capsys.readouterr().err
    assert said.startswith("interrupted; a run was brought to rest and the arm disarmed")
    assert "longreach stop" not in said


def test_a_no_moves_nothing(tmp_path: Path) -> None:
    loaded, asked = load_rig(rig_copy(tmp_path)), []

    def no(question: str) -> bool:
        asked.append(question)
        return False

    with LockstepBench(loaded, tmp_path / "logs") as bench:
        with pytest.raises(Exception, match="not allowed by the operator"):
            polarity(Context(loaded, bench, tmp_path, no, lambda line: None))
        assert bench.readings()["rotary.position"].std() < 1e-3
    assert len(asked) == 1
    assert not list((tmp_path / "logs").glob("*.mcap"))


def test_the_gap_step_goes_on_from_the_runs_of_an_earlier_session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def find(rig: str, fit: list[Path], holdout: list[Path], *others: object) -> Any:
        asked.append((fit, holdout))
        return SimpleNamespace(verdict=SimpleNamespace(word="none", why="the model explains the log"), content={"findings": []})

    monkeypatch.setattr("gap.find.find", find)
    rig, logs = rig_copy(tmp_path), [tmp_path / "unshaped.mcap", tmp_path / "shaped.mcap"]
    moved = Outcome(True, "paper_line with adaptive", logs=[str(log) for log in logs])
    Commissioning(tmp_path, "my_rig").keep(record_of(SHAPED_MOVE, moved, "somebody", "simulated", ""))

    def resumed() -> Outcome:
        loaded, records = load_rig(rig), Commissioning.read(tmp_path, "my_rig").records
        with LockstepBench(loaded, tmp_path / "logs") as bench:
            return gap(Context(loaded, bench, tmp_path, lambda question: True, lambda line: None, records=records))

    assert "--again 'first shaped move'" in resumed().text
    assert asked == []
    for log in logs:
        log.touch()
    assert resumed().passed
    assert asked == [(logs[:1], logs[1:])]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_copy_is_commissioned_to_its_first_shaped_move(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = rig_copy(tmp_path)
    answer, _ = commission(capsys, rig, "--identify", "payload", "--effort", "1", "--until", "first shaped move")
    steps = answer["steps"]
    assert list(steps) == list(NAMES[:-1])
    assert [name for name, step in steps.items() if step["outcome"]["passed"] is False] == []
    payload = next(value for value in steps["identification"]["outcome"]["values"] if value["what"].startswith("payload"))
    assert float(payload["value"].split()[0]) == pytest.approx(45 * 0.45359237, rel=0.05)
    left = {value["what"]: float(value["value"].split()[0]) for value in steps["first shaped move"]["outcome"]["values"][2:]}
    assert left["vibration left, adaptive"] < 0.5 * left["vibration left, unshaped"]
    assert Path(steps["first shaped move"]["outcome"]["files"][0]).exists()
    page = Path(answer["page"])
    assert outside_links(page) == []
    assert all(f". {name}</h2>" in page.read_text() for name in NAMES[:-1])
    for width in (1280, 400):
        seen = opened(page, tmp_path, width)
        assert seen.console == []
        assert seen.width <= width
