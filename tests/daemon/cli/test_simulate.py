"""`longreach simulate`: the same cycles as the daemon's own loop in lockstep, and sweeps that say what each run changed."""

from __future__ import annotations

import json
import re
import shlex
from io import StringIO
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from mcap.reader import make_reader
from rich.console import Console

from config.errors import UsageError
from config.loading.load import load_rig
from config.loading.stated_units import sentence_units
from config.stated_sentences import StatedSentences
from daemon.cli.demo.demo_command import requests as demo_requests
from daemon.cli.demo.demo_runs import DemoRuns
from daemon.cli.main import main
from daemon.cli.simulate.outcome import JointOutcome, RunOutcome
from daemon.cli.simulate.runs import SimulatedRun
from daemon.cli.simulate.sweep import assignment, cases
from daemon.cli.simulate.table import below, table
from daemon.lockstep import run_lockstep
from recording.files.reader import read_log

SHORT = ["ornl_testbed", "jog", "--set", "maneuver.joint=rotary", "--set", "maneuver.by=2 deg"]


def test_a_simulated_run_is_the_lockstep_daemons(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.mcap"
    assert main(["simulate", *SHORT, "--shaper", "zvd", "-o", str(out), "--seed", "3"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"rotary: following error \S+ deg rms", said)
    assert re.search(r"prismatic: following error \S+ in rms", said)
    request = {"maneuver": {"name": "jog"}, "parameters": ["joint=rotary", "by=2 deg"], "shaper": {"kind": "zvd"}, "approach": True}
    (log,) = run_lockstep(load_rig("ornl_testbed"), [request], tmp_path / "daemon", seed=3)
    ours, theirs = read_log(out).columns, read_log(log).columns
    for name, values in theirs.items():
        np.testing.assert_array_equal(ours[name], values, err_msg=name)


def cycles(log: Path) -> list[bytes]:
    """The records of every cycle as they stand in the file, read by MCAP's own library."""
    with log.open("rb") as file:
        return [message.data for _, _, message in make_reader(file).iter_messages(topics=["/cycle"])]


@pytest.mark.slow
def test_the_line_of_the_paper_is_the_demos_in_lockstep_bit_for_bit(tmp_path: Path) -> None:
    """The same request by the two commands' own ways."""
    filter_name, request = next((name, r) for name, r in demo_requests([]).items() if name == "adaptive")
    rig = load_rig("ornl_testbed")
    demo = DemoRuns(rig, tmp_path / "demo", Mock(), lockstep="asked for")
    demo.run({filter_name: request})
    out = tmp_path / "line.mcap"
    assert main(["simulate", "ornl_testbed", request["maneuver"]["name"], "--shaper", filter_name, "-o", str(out)]) == 0
    ours, theirs = cycles(out), cycles(demo.logs[filter_name])
    assert len(ours) > 18_000
    assert ours == theirs


def test_a_sweep_runs_every_case_and_a_refused_one_is_a_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sweep = ["--sweep", "maneuver.by=1 deg,400 deg", "--sweep", "shaper=none,zvd"]
    status = main(["simulate", "ornl_testbed", "jog", "--set", "maneuver.joint=rotary", *sweep, "-o", str(tmp_path / "s.mcap"), "--json"])
    assert status == 1  # two of them were refused
    runs = json.loads(capsys.readouterr().out)["runs"]
    assert [run["case"] for run in runs] == [
        {"maneuver.by": by, "shaper": shaper} for by in ("1 deg", "400 deg") for shaper in ("none", "zvd")
    ]
    for run in runs[:2]:
        columns = read_log(Path(run["outcome"]["log"])).columns
        moved = columns["rotary.target"][-1] - columns["rotary.target"][0]
        assert moved == pytest.approx(np.radians(1.0), abs=5e-4)  # it holds where friction left it
    for run in runs[2:]:
        assert run["outcome"] is None
        assert "rotary" in run["refused"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s-1.mcap", "s-2.mcap"]


def test_a_sweep_fits_80_columns_with_every_number_whole(tmp_path: Path) -> None:
    """Two joints and two swept keys: nothing is cut with an ellipsis; logs and refusals stand below."""
    testbed = load_rig("ornl_testbed")
    (log,) = run_lockstep(testbed, [{"maneuver": {"name": "jog"}}], tmp_path)
    joint = JointOutcome(0.00123456, 0.2, 0.1, 3.123456)
    made = RunOutcome(log, 4.0, {"rotary": joint, "prismatic": joint}, 0.0123456, 0.5)
    swept = [{"servo.rotary.gain": f"{gain} V/deg", "shaper": "adaptive_zv"} for gain in ("0.25", "0.35")]
    runs = [SimulatedRun(swept[0], made, ""), SimulatedRun(swept[1], None, "above 0.9144 m")]
    shown = StringIO()
    Console(width=80, file=shown).print(table(runs))
    said = shown.getvalue()
    assert "…" not in said
    assert re.search(r"1 +0.25 V/deg +adaptive_zv +0.0707 +3.12 +0.0486 +3.12 +0.0123", said)
    assert below(runs, StatedSentences(sentence_units(testbed.text))) == [f"log: {log}", "run 2 refused: above 36 in"]


def test_sweeps_are_read_as_written() -> None:
    assert cases([]) == [{}]
    assert cases(["servo.rotary.gain=0.2..0.5 V/deg:4"]) == [{"servo.rotary.gain": f"{value} V/deg"} for value in (0.2, 0.3, 0.4, 0.5)]
    assert cases(["a=-1e-3..1e-3:3"]) == [{"a": "-0.001"}, {"a": "0"}, {"a": "0.001"}]
    assert cases(["a=30 in..40 in:2"]) == cases(["a=30..40 in:2"]) == [{"a": "30 in"}, {"a": "40 in"}]
    assert len(cases(["a=1..2:3", "shaper=none,zvd"])) == 6
    assert assignment("a.b = 3 in") == ("a.b", "3 in")


@pytest.mark.parametrize("text", ["a", "a=", "=1..2:3", "a=1..2", "a=1..2:0", "a=x..2:3", "a=1 in..2 mm:3", "a=1 in..2:3"])
def test_a_sweep_that_cannot_be_read_says_how_to_write_one(text: str) -> None:
    with pytest.raises(UsageError, match=r"Write KEY=FROM\.\.TO UNIT:COUNT"):
        cases([text])


def test_from_here_where_the_maneuver_does_not_start_is_advised_against(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--approach` is an option of `start` alone."""
    words = ["simulate", "ornl_testbed", "paper_line", "--set", "maneuver.y0=30 in", "-o", str(tmp_path / "a.mcap")]
    assert main([*words, "--from-here"]) == 1
    said = capsys.readouterr().err.splitlines()
    assert "prismatic is at 40 in, the start is 30 in" in said[0]
    assert said[1] == shlex.join(["next:", "longreach", *words])


def test_an_existing_log_is_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.mcap"
    out.write_bytes(b"mine")
    assert main(["simulate", *SHORT, "-o", str(out)]) == 2
    assert "the log exists already" in capsys.readouterr().err
    assert out.read_bytes() == b"mine"
