"""Steps of a reading that the rig file does not have are seen in the values themselves, and only there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from gap.data.coarse_steps import coarse_steps, readable
from gap.data.data_check import check
from gap.data.measured import Measured, load
from gap.find import search_gap
from gap.outcome.findings import LeastSize, not_seen
from gap.outcome.model_file import with_step_lines
from tests.support.gap import axis_logs
from tests.support.gap.findings_schema import problems as contract_problems

STEP_M = 73e-6  # 73 of the encoder's counts of 1 µm


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Measured]:
    folder, rig = tmp_path_factory.mktemp("logs"), axis_logs.axis_rig()
    return [load(axis_logs.write(folder / f"{seed}.csv", axis_logs.simulated(rig, seed)), rig) for seed in (11, 12)]


def stepped(log: Measured, step_m: float, phase_m: float = 0.0) -> Measured:
    """The log as an encoder with coarse steps writes it, to the counts of its own resolution."""
    channel = log.channels["axis.position"]
    read = phase_m + step_m * np.round((channel.values - phase_m) / step_m)
    return replace(log, channels={**log.channels, "axis.position": replace(channel, values=read, logged=read)})


def test_a_good_encoder_has_none(logs: list[Measured]) -> None:
    assert coarse_steps(logs[:1], logs[1:], axis_logs.axis_rig()) == []


@pytest.mark.parametrize("phase_m", [0.0, 3.1e-5])
def test_steps_in_every_log_are_read_off(logs: list[Measured], phase_m: float) -> None:
    """Wherever the counting begins."""
    coarse = [stepped(log, STEP_M, phase_m) for log in logs]
    (found,) = coarse_steps(coarse[:1], coarse[1:], axis_logs.axis_rig())
    assert (found.where, found.unit) == ("sensor:axis.position", "m")
    assert found.step == pytest.approx(STEP_M, rel=1e-6)
    moves = np.count_nonzero(np.diff(coarse[1].channels["axis.position"].values))
    assert found.t == pytest.approx(np.sqrt(moves * 72.0))  # a share 1/73 would lie on the steps by chance
    assert found.gain == pytest.approx(1.0 - (12 * 2.0**2 + 1.0) / 73.0**2, rel=1e-3)  # noise of 2 µm, counts of 1 µm


def test_uneven_sampling_times_hide_no_steps(tmp_path: Path) -> None:
    """Such samples are moved onto the grid, between the steps; what was logged lies on them."""
    rig = axis_logs.axis_rig()
    uneven = []
    for seed in (11, 12):
        columns = axis_logs.simulated(rig, seed, duration_s=6.0)
        columns["t_s"] = columns["t_s"] + axis_logs.PERIOD_S * np.random.default_rng(seed).uniform(-0.2, 0.2, len(columns["t_s"]))
        columns["axis.position"] = STEP_M * np.round(columns["axis.position"] / STEP_M)
        uneven.append(load(axis_logs.write(tmp_path / f"{seed}.csv", columns), rig))
    moved = uneven[0].channels["axis.position"].values / STEP_M
    assert np.max(np.abs(moved - np.round(moved))) > 0.1
    (found,) = coarse_steps(uneven[:1], uneven[1:], rig)
    assert found.step == pytest.approx(STEP_M, rel=1e-6)
    assert any("moves in steps of" in problem.what for problem in check(uneven, rig))


def test_steps_in_one_log_only_are_no_property_of_the_sensor(logs: list[Measured]) -> None:
    assert coarse_steps([stepped(logs[0], STEP_M)], logs[1:], axis_logs.axis_rig()) == []
    assert coarse_steps([stepped(logs[0], STEP_M)], [stepped(logs[1], 2 * STEP_M)], axis_logs.axis_rig()) == []


def test_steps_below_the_declared_noise_are_none(logs: list[Measured]) -> None:
    """2 µm of noise are as much as steps of 7 µm."""
    for step_m, count in ((6e-6, 0), (9e-6, 1)):
        coarse = [stepped(log, step_m) for log in logs]
        assert len(coarse_steps(coarse[:1], coarse[1:], axis_logs.axis_rig())) == count


def test_a_single_value_between_the_steps_speaks_against_them(logs: list[Measured]) -> None:
    coarse = [stepped(log, STEP_M) for log in logs]
    values = coarse[1].channels["axis.position"].logged
    values[5000] += 0.5 * STEP_M
    assert coarse_steps(coarse[:1], coarse[1:], axis_logs.axis_rig()) == []


def test_a_rig_file_that_has_them_is_not_told(logs: list[Measured]) -> None:

    coarse = [stepped(log, STEP_M) for log in logs]
    found = coarse_steps(coarse[:1], coarse[1:], axis_logs.axis_rig())
    told = rig_from_text(with_step_lines(axis_logs.axis_text(), found))
    assert told.plant is not None
    entry = next(e for e in told.plant.effects if e.effect == "sensor_quantization")
    assert entry.model_dump()["step"] == pytest.approx(STEP_M, rel=1e-5)
    assert coarse_steps(coarse[:1], coarse[1:], told) == []


@pytest.mark.slow
def test_the_search_names_them_beside_what_it_finds(logs: list[Measured], tmp_path: Path) -> None:
    """Here nothing else is missing, and the verdict is not "no gap"."""
    rig = tmp_path / "axis.yaml"
    rig.write_text(axis_logs.axis_text())
    coarse = [stepped(log, STEP_M) for log in logs]
    found = search_gap(load_rig(rig), coarse[:1], coarse[1:], lambda line: None)
    assert contract_problems(found.content) == []
    (item,) = found.content["findings"]
    assert (item["effect"], item["where"], item["confirmed"]) == ("sensor_quantization", "sensor:axis.position", True)
    assert item["parameters"]["step"]["value"] == pytest.approx(STEP_M, rel=1e-5)
    assert found.verdict.word == "named"
    assert "73 times the 1e-06 m of the rig file" in found.verdict.why
    assert "step: 7.3e-05 m" in found.improved_text
    assert not any((row["effect"], row["where"]) == (item["effect"], item["where"]) for row in found.content["not_seen"])


def test_the_smallest_step_that_would_be_read_off_is_claimed_and_kept(logs: list[Measured]) -> None:
    """√(12 · 2² + 1) = 7 µm beside 2 µm of noise in counts of 1 µm."""
    rig = axis_logs.axis_rig()
    claim = readable(logs, rig)["sensor:axis.position"]
    assert claim == pytest.approx(7e-6)
    for factor, count in ((0.98, 0), (1.02, 1)):
        coarse = [stepped(log, factor * claim) for log in logs]
        assert len(coarse_steps(coarse[:1], coarse[1:], rig)) == count


def test_no_step_is_claimed_where_the_values_lie_on_none(logs: list[Measured]) -> None:
    moved = [
        replace(log, channels={n: replace(c, logged=c.logged + 1e-7 * np.sin(np.arange(len(c.logged)))) for n, c in log.channels.items()})
        for log in logs
    ]
    assert readable(moved, axis_logs.axis_rig()) == {}


def test_what_would_have_been_read_off_is_among_what_was_not_seen() -> None:
    claimed = LeastSize("sensor_quantization", "sensor:axis.position", "step", "m", 9e-5)
    for steps, size in (({}, 9e-5), ({claimed.where: 7e-6}, 7e-6)):
        (row,) = not_seen([claimed], frozenset(), steps)
        assert row["smallest_visible"] == pytest.approx(size)
