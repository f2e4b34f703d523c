"""A span cut out of a log is a whole log: the same bytes, the same answers, executable from its first cycle on."""

from __future__ import annotations

from math import nan
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from daemon.checks.declared.driving_by_hand import FACTS
from daemon.checks.interlocks import rig_facts
from daemon.checks.past_checks import walked
from daemon.lockstep import LockstepRig
from recording.evaluation.cut_out import cut_out
from recording.evaluation.replay import reexecute
from recording.files.check import check_log
from recording.files.info import describe
from recording.files.reader import Log, open_rig, read_log
from servo_control.signals import Mode, SetPoint, Wanted
from tests.support.daemon.rigs import JOG, RIG, simple_rig


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Log:
    """A program, then a run by hand through the default filter, on the simulated rig."""
    with LockstepRig(RIG, tmp_path_factory.mktemp("driven")) as rig:
        rig.arm()
        rig.start(JOG)
        rig.until(lambda: not rig.loop.keeper.run.active)
        run = rig.stream()
        rig.until(lambda: rig.mode is Mode.RUNNING)
        for number in range(40):
            rig.set_points.post(SetPoint(run, Wanted.TIP, (0.2, 0.1), 0.001 * number))
            rig.cycles(20)
        rig.set_points.post(SetPoint(run, Wanted.END, (), 0.0))
        rig.until(lambda: not rig.loop.keeper.run.active)
        rig.disarm()
    return read_log(rig.recorder.finished[-1])


def middle_of(log: Log, run: int) -> float:
    moving = log.columns["t_s"][(log.columns["maneuver"] == run) & (log.columns["mode"] == Mode.RUNNING)]
    return float(moving[len(moving) // 2])


@pytest.mark.parametrize("run", [1, 2])
def test_it_holds_the_same_and_executes_again_from_the_middle_of_a_run(driven: Log, run: int, tmp_path: Path) -> None:
    out, start = tmp_path / "part.mcap", middle_of(driven, run)
    end = start + 0.2
    assert cut_out(driven, start, end, out)
    part = read_log(out)
    rows = np.abs(driven.columns["t_s"] - 0.5 * (start + end)) < 0.1005
    cycles = driven.columns["cycle"][rows].tolist()
    for name, values in part.columns.items():
        np.testing.assert_array_equal(values, driven.columns[name][rows], err_msg=name)
    assert part.events == [event for event in driven.events if event.cycle in cycles]
    assert part.set_points == [stamped for stamped in driven.set_points if stamped.cycle in cycles]
    assert reexecute(out).identical
    assert check_log(out).good, check_log(out).text()
    assert {f"run-{run}.json", f"maneuver-{run}.yaml", "rig.yaml", "calibration.json"} <= set(part.attachments)
    assert f"run-{3 - run}.json" not in part.attachments
    assert f"cut out of {driven.path.name}" in describe(part).text()
    assert [path.name for path in tmp_path.iterdir()] == ["part.mcap"]


def test_what_the_checks_of_driving_read_is_the_same(driven: Log, tmp_path: Path) -> None:
    """What was wrong before the cut still counts: the state of the run is in the part."""
    out, start = tmp_path / "part.mcap", middle_of(driven, 2)
    cut_out(driven, start, start + 0.3, out)

    def read(log: Log, first_s: float) -> list[tuple[float, ...]]:
        rig = open_rig(log)
        facts = rig_facts(rig)
        first, last = (int(np.argmin(np.abs(log.columns["t_s"] - moment))) for moment in (first_s, first_s + 0.2))
        return [tuple(values[facts.index(name)] for name in FACTS) for values in walked(log, rig, facts, first, last)]

    assert read(read_log(out), start + 0.01) == read(driven, start + 0.01)


def test_another_reader_finds_a_whole_file(driven: Log, tmp_path: Path) -> None:
    out, start = tmp_path / "part.mcap", middle_of(driven, 1)
    cut_out(driven, start, start + 0.2, out)
    with out.open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
        assert summary is not None
        assert summary.statistics is not None
        cycles = next(channel.id for channel in summary.channels.values() if channel.topic == "/cycle")
        assert summary.statistics.channel_message_counts[cycles] == 201


def test_the_end_of_the_recording_before_is_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daemon.loop.recording_span.ARMED_S", 2.0)
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.until(lambda: len(rig.recorder.finished) == 1)
        rig.cycles(300)
        device.override["rotary.position"] = nan
        rig.cycles(2100)
    first, second = map(read_log, rig.recorder.finished)
    start = middle_of(first, 1)
    out = tmp_path / "parts" / "joined.mcap"
    out.parent.mkdir()
    assert cut_out(second, start, float(second.columns["t_s"][-1]), out)
    joined = read_log(out)
    whole = np.concatenate([first.columns["cycle"], second.columns["cycle"]])
    t = np.concatenate([first.columns["t_s"], second.columns["t_s"]])
    assert joined.columns["cycle"].tolist() == whole[t >= start].tolist()
    assert reexecute(out).identical
    assert check_log(out).good


def test_a_log_that_cannot_be_executed_again_gives_one_that_cannot(driven: Log, tmp_path: Path) -> None:
    lost = read_log(driven.path)
    lost.attachments.pop("controller_state.json")
    assert not cut_out(lost, middle_of(driven, 1), middle_of(driven, 1) + 0.1, tmp_path / "part.mcap")
    assert "controller_state.json" not in read_log(tmp_path / "part.mcap").attachments
