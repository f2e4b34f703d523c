"""Every fault of the data that shows without a simulation is named with its channel and its time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig
from gap.data.channel_check import comparable
from gap.data.data_check import DataProblem, check, refuse_pairing
from gap.data.measured import Measured, load, on_grid
from gap.data.windows import left_in, prepare
from sim_backend.plant import SimulatedRig
from tests.support.gap import axis_logs

Columns = axis_logs.Columns


@pytest.fixture(scope="module")
def columns() -> Columns:
    return axis_logs.simulated(axis_logs.axis_rig(), 1, 6.0)


def problems(tmp_path: Path, columns: Columns, change: Callable[[Columns], Columns]) -> list[DataProblem]:
    rig = axis_logs.axis_rig()
    return check([load(axis_logs.write(tmp_path / "log.csv", columns, change), rig)], rig)


def test_a_good_log_has_no_problem(tmp_path: Path, columns: Columns) -> None:
    assert problems(tmp_path, columns, lambda c: c) == []


def test_a_clipped_channel(tmp_path: Path, columns: Columns) -> None:
    top = float(np.quantile(columns["axis.position"], 0.9))
    found = problems(tmp_path, columns, lambda c: c | {"axis.position": np.minimum(c["axis.position"], top)})
    clipped = next(p for p in found if "clipped" in p.what)
    assert (clipped.channel, clipped.fatal) == ("axis.position", False)
    above = columns["axis.position"] >= top
    first_s = columns["t_s"][1000 + np.argmax(above[1000:])]  # the log begins above
    assert f"first at t = {first_s:.3f} s" in clipped.what


def test_turning_points_and_rests_are_not_taken_for_clipping(tmp_path: Path, columns: Columns) -> None:
    """A coarse encoder stays on its highest count for a while; so does an axis that rests at the end of its stroke."""
    steps = 20e-6
    coarse = problems(tmp_path, columns, lambda c: c | {"axis.position": steps * np.round(c["axis.position"] / steps)})
    assert not any("clipped" in p.what for p in coarse)


def test_quantisation_is_told_from_resolution(tmp_path: Path, columns: Columns) -> None:
    found = problems(tmp_path, columns, lambda c: c | {"axis.position": 2e-4 * np.round(c["axis.position"] / 2e-4)})
    steps = next(p for p in found if "moves in steps" in p.what)
    assert "0.0002 m" in steps.what
    assert "declares 1e-06" in steps.what
    assert not steps.fatal


def test_repeated_times_and_jitter(tmp_path: Path, columns: Columns) -> None:
    def spoil(c: Columns) -> Columns:
        t = c["t_s"].copy()
        t[1000:1010] = t[1000]
        t[2000::7] += 4e-4
        return c | {"t_s": t}

    texts = [p.what for p in problems(tmp_path, columns, spoil)]
    assert any("9 rows repeat or go back in time" in text or "10 rows repeat" in text for text in texts)
    assert any("off the grid by up to 0." in text for text in texts)


def test_too_short(tmp_path: Path, columns: Columns) -> None:
    rig = axis_logs.axis_rig()
    short = axis_logs.write(tmp_path / "short.csv", columns, lambda c: {name: values[:1200] for name, values in c.items()})
    sigma = {"axis.position": 2e-6}
    cut = [prepare(load(short, rig), rig, sigma, 0.2, ["axis.position"])]
    assert cut[0].windows == 4
    with pytest.raises(LogError, match=r"too few windows .*4 windows \(limit: 6 windows\).*--log LOG"):
        left_in(cut, "--log")
    assert len(left_in([*cut, *cut], "--log")) == 2


def test_the_same_measurement_under_another_name_is_no_hold_out(tmp_path: Path, columns: Columns) -> None:
    rig = axis_logs.axis_rig()
    first = load(axis_logs.write(tmp_path / "a.csv", columns), rig)
    again = load(axis_logs.write(tmp_path / "b.csv", columns | {"cycle": np.arange(len(columns["t_s"]))}), rig)
    assert first.sha256 != again.sha256
    with pytest.raises(LogError, match="the hold-out log is a fit log"):
        refuse_pairing([first], [again])


PERIOD_S = 0.002


def arm_log(change: Callable[[Columns], Columns]) -> tuple[Rig, Measured]:
    """Both joints of the testbed moved open loop by different sines, with the tip's deflection."""
    rig = rig_from_text(load_rig("ornl_testbed").text)
    t = PERIOD_S * np.arange(4000)
    commands = np.column_stack([0.9 * np.sin(2 * np.pi * 0.31 * t), 0.7 * np.sin(2 * np.pi * 0.17 * t)])
    run = SimulatedRig(rig).run(commands, PERIOD_S)
    columns = {"t_s": t, "rotary.command_V": commands[:, 0], "prismatic.command_V": commands[:, 1]}
    columns |= {name: run[name] for name in ("rotary.position", "prismatic.position")}
    columns |= {"tip.deflection_m": run["tip.deflection"], "tip.acceleration_mps2": run["tip.acceleration"]}
    changed = change(columns)
    return rig, on_grid(Path("arm.csv"), changed, rig, "")


def test_a_dead_tip_sensor() -> None:
    rig, log = arm_log(lambda c: c | {"tip.deflection_m": 0 * c["t_s"]})
    dead = next(p for p in check([log], rig) if p.channel == "tip.deflection")
    assert not dead.fatal
    assert "stands at exactly 0 m from beginning to end while a joint moves (dead channel): not compared in this log" in dead.what
    assert "tip.deflection" not in comparable(log, rig).channels


def test_swapped_commands() -> None:
    def swap(c: Columns) -> Columns:
        return c | {"rotary.command_V": c["prismatic.command_V"], "prismatic.command_V": c["rotary.command_V"]}

    rig, straight = arm_log(lambda c: c)
    assert not any(p.fatal for p in check([straight], rig))
    crossed = next(p for p in check([arm_log(swap)[1]], rig) if "swapped columns" in p.what)
    assert crossed.fatal
    assert "rotary follows prismatic.command_V" in crossed.what


def test_degrees_for_radians() -> None:
    rig, log = arm_log(lambda c: c | {"rotary.position": np.degrees(c["rotary.position"])})
    assert any(p.channel == "rotary.position" and p.fatal and "wrong unit" in p.what for p in check([log], rig))


def test_swapped_joints() -> None:
    def swap(c: Columns) -> Columns:
        return c | {"rotary.position": c["prismatic.position"] + 2, "prismatic.position": c["rotary.position"]}

    rig, log = arm_log(swap)
    assert any(p.fatal and "swapped joints or another rig" in p.what for p in check([log], rig))
