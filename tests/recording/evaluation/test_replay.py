"""A log re-executes bit for bit, a changed bit is found, and a changed gain gives the difference it must."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from config.errors import ConfigError, LogError
from recording.evaluation.replay import controller_state_before, reexecute
from recording.files.reader import read_log
from recording.files.writer import LogWriter
from recording.importing.ingest import ingest
from servo_control.signals import Mode
from tests.support.daemon.rigs import simple_rig
from tests.support.recording import logs, session


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return session.recorded_run(tmp_path_factory.mktemp("replay") / "run.mcap", shaper="adaptive")


def rewritten(
    path: Path, out: Path, change: dict[tuple[str, int], float], *, without: tuple[str, ...] = (), drop: range = range(0)
) -> Path:
    """A copy with some values changed, attachments left out and cycles dropped."""
    log = read_log(path)
    columns = {name: values.copy() for name, values in log.columns.items()}
    for (name, row), value in change.items():
        columns[name][row] = value
    files = {name: ("application/octet-stream", data) for name, data in log.attachments.items() if name not in without}
    writer = LogWriter(out, log.layout, files, {"recording": log.metadata["recording"]})
    for row, values in enumerate(zip(*(column.tolist() for column in columns.values()), strict=True)):
        if row not in drop:
            writer.cycle(int(log.time_ns[row]), log.layout.pack(values))
    writer.close({})
    return out


def test_a_whole_run_is_bit_identical(whole: Path) -> None:
    result = reexecute(whole)
    cycles = read_log(whole).cycles
    assert result.identical
    assert result.text() == f"bit-identical, {cycles} cycles"
    assert np.ptp(read_log(whole).columns["rotary.reference"]) > 1.0  # the arm did move


def test_stops_faults_lost_samples_and_a_second_run(tmp_path: Path) -> None:
    recording = session.Session(tmp_path / "a.mcap")
    recording.position = [0.0, 40 * 0.0254]
    recording.cycles(Mode.DISARMED, 20, lost=(0, 1, 2))
    recording.cycles(Mode.HOLDING, 20, lost=(5,))
    recording.start(recording.plan("paper_line", 1, "three_term"))
    recording.cycles(Mode.RUNNING, 900, lost=(100, 101))
    recording.until(Mode.STOPPING, lambda outputs: outputs.stopped)
    recording.cycles(Mode.HOLDING, 20)
    recording.cycles(Mode.FAULT, 30, lost=range(10, 20))
    recording.cycles(Mode.DISARMED, 10)
    recording.position = [0.0, 40 * 0.0254]
    recording.cycles(Mode.HOLDING, 10)
    recording.start(recording.plan("paper_line", 2))
    recording.cycles(Mode.RUNNING, 500)
    recording.cycles(Mode.FAULT, 5)
    result = reexecute(recording.close())
    assert result.text() == f"bit-identical, {recording.cycle} cycles"


def test_a_file_that_begins_in_the_middle_of_a_run(tmp_path: Path) -> None:
    """Rotation: the second file carries the controller's state, and re-executes from it alone."""
    first = session.Session(tmp_path / "a.mcap")
    first.position = [0.0, 40 * 0.0254]
    plan = first.plan("paper_line", 1, "adaptive")
    first.cycles(Mode.HOLDING, 10)
    first.start(plan)
    first.cycles(Mode.RUNNING, 1234)
    state = json.dumps(first.controller.snapshot()).encode()
    first.close()
    second = session.Session(tmp_path / "unused.mcap")
    files = {"rig.yaml": ("application/yaml", second.loaded.text.encode()), "controller_state.json": ("application/json", state)}
    files["run-1.json"] = ("application/json", plan.request.as_json().encode())
    first.writer = LogWriter(tmp_path / "b.mcap", first.layout, files, logs.metadata())
    first.cycles(Mode.RUNNING, 700)
    first.close()
    assert reexecute(tmp_path / "b.mcap").text() == "bit-identical, 700 cycles"


def test_one_changed_bit_is_found(whole: Path, tmp_path: Path) -> None:
    value = float(read_log(whole).columns["rotary.command_V"][2000])
    (bits,) = struct.unpack("<Q", struct.pack("<d", value))
    (changed,) = struct.unpack("<d", struct.pack("<Q", bits ^ 1))
    path = rewritten(whole, tmp_path / "a.mcap", {("rotary.command_V", 2000): changed, ("prismatic.target", 3000): 0.0})
    result = reexecute(path)
    assert not result.identical
    assert result.first is not None
    assert (result.first.cycle, result.first.signal) == (2000, "rotary.command_V")
    assert result.text() == (
        f"first difference at cycle 2000, t = 2.000000 s: rotary.command_V is {changed!r} ({changed.hex()}) in the log, "
        f"{value!r} ({value.hex()}) re-executed"
    )


def test_a_changed_input_shows_in_the_outputs(whole: Path, tmp_path: Path) -> None:
    position = float(read_log(whole).columns["rotary.position"][1500])
    result = reexecute(rewritten(whole, tmp_path / "a.mcap", {("rotary.position", 1500): position + 1e-9}))
    assert result.first is not None
    assert (result.first.cycle, result.first.signal) == (1500, "rotary.velocity")


def test_re_execution_ends_at_a_gap_and_says_so(whole: Path, tmp_path: Path) -> None:
    result = reexecute(rewritten(whole, tmp_path / "a.mcap", {}, drop=range(700, 710)))
    assert not result.identical
    assert result.text() == (
        "not re-executed as a whole: identical up to a gap, 700 cycles. "
        "The log lacks the cycles between 699 and 710, so re-execution ends there."
    )


def test_a_cut_log_re_executes_up_to_its_cut(whole: Path, tmp_path: Path) -> None:
    content = whole.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(content[: len(content) // 2])
    cycles = read_log(tmp_path / "cut.mcap").cycles
    assert 1000 < cycles < read_log(whole).cycles
    said = reexecute(tmp_path / "cut.mcap").text()
    assert said.startswith(f"bit-identical, {cycles} cycles. The log is still being recorded, or was cut at t = ")


def test_what_if_the_gain_were_higher(whole: Path) -> None:
    """With the positions as they were, a proportional servo's command changes by the change of gain times the error."""
    log = read_log(whole)
    result = reexecute(whole, ["servo.rotary.gain=0.45 V/deg"])
    error = log.columns["rotary.reference"] - log.columns["rotary.position"]
    expected = np.degrees(error[np.isin(log.columns["mode"], (Mode.HOLDING, Mode.RUNNING))]) * 0.10
    found = {difference.signal: difference for difference in result.differences}
    assert found["rotary.command_V"].largest == pytest.approx(np.max(np.abs(expected)), rel=0.02)
    assert found["rotary.command_V"].unit == "V"
    assert found["prismatic.command_V"].largest == 0.0
    lines = result.text().splitlines()
    assert lines[0] == f"{log.cycles} cycles with servo.rotary.gain=0.45 V/deg and the positions of the log:"
    assert lines[1].split()[:3] == ["rotary.command_V", "V", "rms"]
    assert len(lines) == 2


def test_an_override_of_the_present_value_changes_nothing(whole: Path) -> None:
    assert reexecute(whole, ["servo.rotary.gain=0.35 V/deg"]).text().endswith("nothing changes")


def test_an_unknown_override_names_the_nearest(whole: Path) -> None:
    with pytest.raises(ConfigError, match="gain"):
        reexecute(whole, ["servo.rotary.gian=1"])


@pytest.mark.parametrize("name", ["rig.yaml", "controller_state.json", "run-1.json"])
def test_a_log_that_lacks_something_is_refused(whole: Path, tmp_path: Path, name: str) -> None:
    path = rewritten(whole, tmp_path / "a.mcap", {}, without=(name,))
    with pytest.raises(LogError) as caught:
        reexecute(path)
    assert f"a.mcap: the log lacks {name}, which re-execution needs. `longreach log check {path}` says" in str(caught.value)


def test_no_cycle_is_not_bit_identical(whole: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError) as caught:
        reexecute(rewritten(whole, tmp_path / "a.mcap", {}, drop=range(read_log(whole).cycles)))
    assert "a.mcap: the log holds no cycle to re-execute. `longreach log check " in str(caught.value)


def test_a_log_whose_first_cycles_are_lost_is_refused(tmp_path: Path) -> None:
    """The state in it is that before the cycles that are lost."""
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.cycles(50)
    path = rig.recorder.finished[-1]
    first = int(read_log(path).columns["cycle"][0])
    assert reexecute(path).identical
    lost = rewritten(path, tmp_path / "a.mcap", {}, drop=range(7))
    with pytest.raises(LogError) as caught:
        reexecute(lost)
    assert f"it begins with cycle {first + 7} (limit: cycle {first})" in str(caught.value)
    with pytest.raises(LogError, match="lacks its first cycles"):
        controller_state_before(read_log(lost), 3)


def test_imported_data_cannot_be_re_executed(tmp_path: Path) -> None:
    (tmp_path / "d.csv").write_text("t_s,axis.position\n0,1\n1,2\n")
    ingest(tmp_path / "d.csv", None, tmp_path / "a.mcap")
    with pytest.raises(LogError) as caught:
        reexecute(tmp_path / "a.mcap")
    assert "a.mcap: imported data have no controller to re-execute. Only logs that longreach recorded can be re-executed" in str(
        caught.value
    )
