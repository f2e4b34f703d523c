"""A second position sensor of a joint: a signal, a column of the log, a check beside the first sensor, and nothing to the servo."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config.errors import ConfigError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.lockstep import LockstepRig, run_lockstep
from gap.data.measured import load
from recording.evaluation.replay import reexecute
from recording.files.export import export
from recording.files.reader import Log, read_log
from recording.format.layout import CycleLayout
from servo_control.signals import Mode
from tests.support.daemon.simple_device import SimpleDevice, factory

MOVE: dict[str, Any] = {
    "maneuver": {"name": "joint_steps"},
    "parameters": {
        "start": {"axis": "0 m"},
        "steps": [{"joint": "axis", "by": "50 mm", "speed": "0.1 m/s", "acceleration": "1 m/s^2", "hold": "0.3 s"}],
    },
}
# It stands 0.5 mm beside the first.
_SIGNAL = """  axis.second_position:
    device: plant
    channel: axis.second_position
    calibration: {scale: 4 um, offset: 0.5 mm}
    required: false

outputs:
"""
_SENSOR = "    axis.second_position: {resolution: 4 um, noise: 2 um, low: -0.10 m, high: 0.35 m}\n  effects:\n"
COLUMNS = ("second_position", "second_position_raw", "second_position_age_s")


def measured_twice(*changes: tuple[str, str]) -> LoadedRig:
    """force_axis with that sensor, and with texts replaced."""
    text = load_rig("force_axis").text
    for old, new in (("outputs:\n", _SIGNAL), ("  effects:\n", _SENSOR), *changes):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return LoadedRig(rig_from_text(text), text, "axis.yaml")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return read_log(run_lockstep(measured_twice(), [MOVE], tmp_path_factory.mktemp("second"))[0])


def test_the_log_holds_what_the_sensor_reads(log: Log) -> None:
    second, first = log.columns["axis.second_position"], log.columns["axis.position"]
    assert np.ptp(first) > 0.045
    np.testing.assert_allclose(second - first, 0.5e-3, atol=20e-6)
    np.testing.assert_allclose(second, 0.5e-3 + 4e-6 * log.columns["axis.second_position_raw"], atol=1e-12)
    assert np.all(log.columns["axis.second_position_age_s"] == 0.0)
    assert {f.name: f.unit for f in log.layout.fields}["axis.second_position"] == "m"


def test_the_servo_does_not_see_it(log: Log, tmp_path: Path) -> None:
    plain = read_log(run_lockstep(load_rig("force_axis"), [MOVE], tmp_path)[0])
    np.testing.assert_array_equal(log.columns["axis.command_V"], plain.columns["axis.command_V"])
    assert reexecute(log.path).identical


def test_without_it_the_layout_is_as_it_was() -> None:
    plain, twice = (CycleLayout.of_rig(r.rig) for r in (load_rig("force_axis"), measured_twice()))
    names = [field.name for field in twice.fields]
    assert [name for name in names if "second" in name] == [f"axis.{column}" for column in COLUMNS]
    assert [name for name in names if "second" not in name] == [field.name for field in plain.fields]
    assert "second" not in CycleLayout(("rotary", "prismatic")).schema_text


def test_joints_of_one_motion_may_differ_in_it() -> None:
    layout = CycleLayout(("boom", "stick"), ["linear", "linear"], {"stick"})
    assert not layout.has("boom.second_position")
    assert layout.has("stick.second_position_raw")


def test_it_goes_out_to_csv_and_comes_back(log: Log, tmp_path: Path) -> None:
    export(log, tmp_path / "axis.csv")
    back = load(tmp_path / "axis.csv", measured_twice().rig)
    channel = back.channels["axis.second_position"]
    assert channel.unit == "m"
    np.testing.assert_allclose(channel.values[np.isfinite(channel.values)][:100], log.columns["axis.second_position"][:100])


def test_sensors_that_disagree_stop_the_run(tmp_path: Path) -> None:
    """The second sensor reads 10 % less: after 5 of the 50 mm it is 0.5 mm off, a fortieth of the following error limit."""
    wrong = measured_twice(
        ("offset: 0.5 mm", "offset: 0 mm"),
        ("interlocks:\n", "interlocks:\n  plausibility: {apart: 0.025}\n"),
        ("  effects:\n", "  effects:\n    - {effect: sensor_scale, where: sensor:axis.second_position, factor: 0.9}\n"),
    )
    with LockstepRig(wrong, tmp_path) as rig:
        rig.arm()
        rig.start(MOVE)
        rig.until(lambda: not rig.loop.keeper.run.active)
        assert rig.mode is Mode.FAULT
        assert "axis positions apart (plant.axis.second_position)" in rig.loop.keeper.why_fault
        assert 0.5e-3 < rig.value("axis.positions_apart") < 0.6e-3


def test_a_second_sensor_that_is_gone_agrees_with_nothing(tmp_path: Path) -> None:
    """Where a limit compares the two, the last difference must not go on passing it."""
    guarded = measured_twice(("interlocks:\n", "interlocks:\n  plausibility: {apart: 0.1}\n"))
    made: list[SimpleDevice] = []
    with LockstepRig(guarded, tmp_path, create=factory(made)) as rig:
        made[0].override["axis.second_position"] = made[0].positions["axis"]
        rig.arm()
        made[0].override["axis.second_position"] = math.nan
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert "axis positions apart" in rig.loop.keeper.why_fault


def test_a_limit_on_what_is_not_measured_is_refused() -> None:
    text = load_rig("force_axis").text.replace("interlocks:\n", "interlocks:\n  plausibility: {apart: 0.1}\n")
    with pytest.raises(ConfigError, match=r"interlocks.plausibility.apart needs a signal JOINT.second_position"):
        rig_from_text(text)
