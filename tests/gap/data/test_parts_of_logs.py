"""Logs as users have them: parts of a file, gaps, joints pressed on a stop, channels that some logs lack."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from config.loading.load import LoadedRig, rig_from_text
from gap.data.at_stop import at_stop
from gap.data.channel_check import channel_problems
from gap.data.data_check import refuse_pairing
from gap.data.experiments import experiments_of
from gap.data.log_parts import load_parts
from gap.data.measured import load, on_grid
from gap.data.windows import prepare
from gap.find import in_each
from gap.fitting.evaluation import costing, evaluate, mean_channel_costs
from gap.fitting.model import Model
from gap.settings import Settings
from tests.support.gap import axis_logs

Columns = axis_logs.Columns
SIGMA = {"axis.position": 2e-6}


@pytest.fixture(scope="module")
def columns() -> Columns:
    return axis_logs.simulated(axis_logs.axis_rig(), 1, 6.0)


def test_a_part_of_a_log_is_what_was_asked_for(tmp_path: Path, columns: Columns) -> None:
    path, rig = axis_logs.write(tmp_path / "a.csv", columns), axis_logs.axis_rig()
    (part,) = load_parts([f"{path}@1.5:3"], rig)
    (end,) = load_parts([f"{path}@4:"], rig)
    assert (part.t_s[0], part.t_s[-1]) == pytest.approx((1.5, 3.0), abs=1e-9)
    assert (end.t_s[0], end.t_s[-1]) == pytest.approx((4.0, 5.999), abs=1e-9)
    np.testing.assert_allclose(part.channels["axis.position"].values, columns["axis.position"][1500:3001], rtol=1e-8)


def test_gaps_that_are_most_of_a_log_make_two_logs_and_a_short_one_does_not(tmp_path: Path, columns: Columns) -> None:
    def without(first: float, last: float) -> list[float]:
        keep = (columns["t_s"] < first) | (columns["t_s"] > last)
        path = axis_logs.write(tmp_path / "gap.csv", columns, lambda c: {name: values[keep] for name, values in c.items()})
        return [float(log.t_s[0]) for log in load_parts([path], axis_logs.axis_rig())]

    assert without(1.2, 4.8) == pytest.approx([0.0, 4.801])
    assert without(2.0, 3.5) == pytest.approx([0.0])


def test_a_part_that_is_not_there_names_the_span_of_the_log(tmp_path: Path, columns: Columns) -> None:
    path = axis_logs.write(tmp_path / "a.csv", columns)
    with pytest.raises(LogError, match=r"runs from 0 to 5.999 s") as refused:
        load_parts([f"{path}@7:9"], axis_logs.axis_rig())
    assert f"{path}@FROM:TO" in str(refused.value)


def test_a_part_that_is_no_span_of_time_says_how_to_write_one(tmp_path: Path, columns: Columns) -> None:
    path = axis_logs.write(tmp_path / "a.csv", columns)
    for part in ("a:b", "1:2s", "1-2:3"):
        with pytest.raises(LogError, match="is no span of time"):
            load_parts([f"{path}@{part}"], axis_logs.axis_rig())


def test_two_parts_of_one_file_are_a_pair_only_where_they_do_not_overlap(tmp_path: Path, columns: Columns) -> None:
    path, rig = axis_logs.write(tmp_path / "a.csv", columns), axis_logs.axis_rig()
    first, second, across = load_parts([f"{path}@0:3", f"{path}@3.1:6", f"{path}@2:5"], rig)
    refuse_pairing([first], [second])
    with pytest.raises(LogError, match="hold-out log is a fit log"):
        refuse_pairing([first], [across])


def pressed(columns: Columns) -> Columns:
    """The axis driven onto the upper end of its travel from 2 to 3.5 s, then left there with no command until 4 s."""
    high = axis_logs.axis_rig().plant.joints["axis"].travel[1]  # type: ignore[union-attr]
    t, position, command = columns["t_s"], columns["axis.position"].copy(), columns["axis.command_V"].copy()
    there = (t >= 2.0) & (t < 4.0)
    position[there] = high + 1e-6 * np.random.default_rng(3).standard_normal(there.sum())
    command[there] = np.where(t[there] < 3.5, 5.0, 0.0)
    return columns | {"axis.position": position, "axis.command_V": command}


def test_windows_at_a_stop_are_left_out_and_rest_without_pressing_is_not(tmp_path: Path, columns: Columns) -> None:
    rig = axis_logs.axis_rig()
    log = load(axis_logs.write(tmp_path / "stop.csv", columns, pressed), rig)
    stop = at_stop(log, rig)[:, 0]
    assert stop[2100:3900].all()
    assert not stop[:1900].any()
    assert not stop[4100:].any()
    starts = prepare(log, rig, SIGMA, 0.2, ["axis.position"]).plan.starts
    assert not np.any((starts > 1810) & (starts < 3990))
    assert starts.min() < 1810
    waiting = pressed(columns) | {"axis.command_V": np.where((columns["t_s"] >= 2) & (columns["t_s"] < 4), 0.0, columns["axis.command_V"])}
    rests = load(axis_logs.write(tmp_path / "rest.csv", waiting), rig)
    assert not at_stop(rests, rig).any()


def test_readings_a_little_beyond_the_range_are_noise(tmp_path: Path, columns: Columns) -> None:
    """2 % of the range; more is another unit."""
    rig = axis_logs.axis_rig()
    log = load(axis_logs.write(tmp_path / "a.csv", columns), rig)
    channel = log.channels["axis.position"]
    top = float(np.nanmax(channel.values))

    def fatal(high: float) -> bool:
        sensor = rig.plant.sensors["axis.position"].model_copy(update={"high": high})  # type: ignore[union-attr]
        return any(problem.fatal for problem in channel_problems(log, channel, sensor, True))

    assert not fatal(top / 1.01)
    assert fatal(top / 1.3)


SECOND = "    axis.second_position: {resolution: 1 um, noise: 2 um, low: -0.10 m, high: 0.35 m}\n"


def test_a_channel_that_one_log_lacks_is_missing_in_that_log_alone(columns: Columns) -> None:
    """Two sensors of one position, of which the second log has one: both are compared, each where it is."""
    text = axis_logs.axis_text().replace("  effects:\n", SECOND + "  effects:\n")
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    both = on_grid(Path("both.csv"), columns | {"axis.second_position": columns["axis.position"]}, loaded.rig, "1")
    other = axis_logs.simulated(axis_logs.axis_rig(), 2, 6.0)
    one = on_grid(Path("one.csv"), other, loaded.rig, "2")
    names, (first,), (second,) = experiments_of(loaded, [both], [one], Settings())
    assert sorted(names) == ["axis.position", "axis.second_position"]
    k = names.index("axis.second_position")
    assert np.isfinite(first.measured).all()
    assert not np.isfinite(second.measured[:, :, k]).any()
    model = Model(loaded.rig, (), np.empty(0))
    costs = [evaluate(experiment, model, None) for experiment in (first, second)]
    tau = costing([first, second], [e.left for e in costs]).tau
    assert tau == pytest.approx(costing([first], [costs[0].left]).tau, rel=0.3)  # what is not there has no correlation time
    assert np.isnan(costs[1].channel_costs[k])
    np.testing.assert_allclose(mean_channel_costs(costs)[k], costs[0].channel_costs[k])
    assert in_each([both, one], names)[1] == "one.csv: compared axis.position; without axis.second_position"
