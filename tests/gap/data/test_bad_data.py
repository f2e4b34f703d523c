"""What cannot carry a verdict is refused, with the channel, the place and what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.errors import EXIT_UNUSABLE_DATA, LogError
from config.loading.load import load_rig
from gap.data.data_check import check, same_maneuver
from gap.data.log_parts import load_parts
from gap.data.measured import Measured, load
from gap.find import find
from longreach import run_plant
from tests.support.gap import axis_logs, worn_axis

Columns = axis_logs.Columns


@pytest.fixture(scope="module")
def columns() -> Columns:
    return axis_logs.simulated(axis_logs.axis_rig(), 1, 6.0)


def refusal(tmp_path: Path, first: Path, holdouts: list[Path]) -> str:
    model = tmp_path / "axis.yaml"
    model.write_text(axis_logs.axis_text())
    with pytest.raises(LogError) as caught:
        find(model, [first], holdouts, tmp_path / "out", lambda line: None)
    assert caught.value.exit_status == EXIT_UNUSABLE_DATA
    assert not (tmp_path / "out").exists()
    return str(caught.value)


def test_one_log_only(tmp_path: Path, columns: Columns) -> None:
    text = refusal(tmp_path, axis_logs.write(tmp_path / "a.csv", columns), [])
    assert "no hold-out log" in text
    assert "--holdout" in text


def test_hold_out_is_the_fit_log(tmp_path: Path, columns: Columns) -> None:
    log = axis_logs.write(tmp_path / "a.csv", columns)
    copy = axis_logs.write(tmp_path / "b.csv", columns)
    assert "the hold-out log is a fit log" in refusal(tmp_path, log, [copy])


def spoiled(tmp_path: Path, columns: Columns, change: object) -> str:
    bad = axis_logs.write(tmp_path / "bad.csv", columns, change)  # type: ignore[arg-type]
    return refusal(tmp_path, bad, [axis_logs.write(tmp_path / "good.csv", columns)])


def test_no_excitation(tmp_path: Path, columns: Columns) -> None:
    still = {"t_s": columns["t_s"], "axis.position": 0.1 + 0 * columns["t_s"], "axis.command_V": 0 * columns["t_s"]}
    assert "no joint moves" in spoiled(tmp_path, columns, lambda c: still)


def test_locked_joint(tmp_path: Path, columns: Columns) -> None:
    text = spoiled(tmp_path, columns, lambda c: c | {"axis.position": 0.1 + 0 * c["t_s"]})
    assert "axis.position" in text
    assert "does not change although axis.command_V spans" in text


def test_stuck_channel(tmp_path: Path, columns: Columns) -> None:
    def stick(c: Columns) -> Columns:
        position, command = c["axis.position"].copy(), c["axis.command_V"].copy()
        position[2000:4500], command[2000:4500] = position[2000], 4.0
        return c | {"axis.position": position, "axis.command_V": command}

    text = spoiled(tmp_path, columns, stick)
    assert "stuck channel" in text
    assert "from t = 2.00" in text
    assert f"{tmp_path / 'bad.csv'}@FROM:TO" in text


def test_millimetres_for_metres(tmp_path: Path, columns: Columns) -> None:
    text = spoiled(tmp_path, columns, lambda c: c | {"axis.position": 1000 * c["axis.position"]})
    assert "wrong unit, swapped channel or another rig" in text


def test_another_rigs_log(tmp_path: Path, columns: Columns) -> None:
    other = {name.replace("axis.", "boom."): values for name, values in columns.items()}
    text = spoiled(tmp_path, columns, lambda c: other)
    assert "axis.command_V" in text


def test_a_recording_of_another_rig_with_the_same_joints_is_a_warning(tmp_path: Path, columns: Columns) -> None:
    """The search goes on: the file may only have been renamed. A table says nothing about its rig."""
    rig = axis_logs.axis_rig()
    own, other = (worn_axis.write_recording(tmp_path / f"{name}.mcap", columns, worn_axis.BEGUN, name) for name in (rig.name, "other"))
    table = axis_logs.write(tmp_path / "a.csv", columns)
    (problem,) = [each for each in check([load(path, rig) for path in (own, other, table)], rig) if "recorded on" in each.what]
    assert (problem.where, problem.fatal) == (str(other), False)
    assert problem.what == f"was recorded on the rig other, and the model is {rig.name}"
    assert [part.rig_name for part in load_parts([other, table], rig)] == ["other", ""]


def test_time_gap_and_jitter_are_named_and_survived(tmp_path: Path, columns: Columns) -> None:
    keep = np.ones(len(columns["t_s"]), dtype=bool)
    keep[3000:3400] = False
    log = load(axis_logs.write(tmp_path / "gap.csv", {name: values[keep] for name, values in columns.items()}), axis_logs.axis_rig())
    problems = [p.text() for p in check([log], axis_logs.axis_rig())]
    assert any("gap of 0.400 s from t = 3.000 s" in text for text in problems)
    assert log.missing.sum() == 400


def test_a_reversed_sensor_is_a_warning(tmp_path: Path, columns: Columns) -> None:
    slow = np.cumsum(columns["axis.command_V"]) * 2e-6
    turned = columns | {"axis.position": 0.1 - slow + slow.mean()}
    log = load(axis_logs.write(tmp_path / "turned.csv", turned), axis_logs.axis_rig())
    problems = check([log], axis_logs.axis_rig())
    assert any("moves against its command" in p.what and not p.fatal for p in problems)


def test_no_steady_rate(tmp_path: Path, columns: Columns) -> None:
    rng = np.random.default_rng(0)
    keep = np.sort(rng.permutation(len(columns["t_s"]))[:2000])
    text = spoiled(tmp_path, columns, lambda c: {name: values[keep] for name, values in c.items()})
    assert "@FROM:TO" in text or "too few windows are left" in text


def test_1_V_and_2_V_are_two_maneuvers_and_a_noisy_repeat_is_one(tmp_path: Path, columns: Columns) -> None:
    rig, noise = axis_logs.axis_rig(), np.random.default_rng(5)
    command = np.repeat([0.0, 1.0, -1.0, 0.0, 1.0, 0.0], 1000)

    def log(name: str, volts: np.ndarray) -> Measured:
        return load(axis_logs.write(tmp_path / f"{name}.csv", columns | {"axis.command_V": volts}), rig)

    one, two = log("one", command), log("two", 2.0 * command)
    assert not same_maneuver(one, two)
    assert not same_maneuver(one, log("other", -command))
    assert same_maneuver(one, log("again", command + 0.01 * noise.standard_normal(command.size)))
    assert same_maneuver(two, log("offset", 2.0 * command + 0.1))


@pytest.mark.parametrize(("times", "slow"), [(1000.0, True), (10.0, False), (1.0, False)], ids=["ms", "a tenth of its speed", "s"])
def test_milliseconds_for_seconds(times: float, slow: bool, tmp_path: Path) -> None:
    """A valve that is worn or wrongly stated may be ten times too slow, and not a hundred times."""
    t = 1e-3 * np.arange(6000)
    commands = np.column_stack([4.0 * np.sin(5.0 * t), 4.0 * np.sin(4.0 * t)])
    run = run_plant("ornl_testbed", commands, 1e-3, start=(0.0, 0.9))
    columns = {"t_s": times * t} | {f"{joint}.command_V": commands[:, k] for k, joint in enumerate(("rotary", "prismatic"))}
    log = axis_logs.write(
        tmp_path / "log.csv", columns | {f"{joint}.position": run[f"{joint}.position"] for joint in ("rotary", "prismatic")}
    )
    rig = load_rig("ornl_testbed").rig
    told = [problem.what for problem in check([load(log, rig)], rig) if "are the times in ms?" in problem.what]
    assert len(told) == (2 if slow else 0)
