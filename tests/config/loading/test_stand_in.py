"""The simulated rig in the place of a rig's devices: the same arm, so the same run as of the rig that is simulated anyway."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.checking.check import refuse_unusable
from config.errors import ConfigError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from config.loading.stand_in import with_simulated_devices
from daemon.lockstep import run_lockstep
from recording.files.reader import read_log

JOG = {"maneuver": {"name": "jog"}}


def test_a_rig_that_is_simulated_already_stays_as_it_is() -> None:
    loaded = load_rig("ornl_testbed")
    assert with_simulated_devices(loaded) is loaded


def test_the_testbed_on_real_buses_runs_in_lockstep_bit_for_bit_as_the_simulated_one(tmp_path: Path) -> None:
    (ours,) = run_lockstep(with_simulated_devices(load_rig("ornl_testbed_can")), [JOG], tmp_path / "can")
    (theirs,) = run_lockstep(load_rig("ornl_testbed"), [JOG], tmp_path / "simulated")
    ours_columns, their_columns = read_log(ours).columns, read_log(theirs).columns
    shared = [name for name in their_columns if name in ours_columns]
    assert {"rotary.position", "rotary.command_V", "prismatic.position"} <= set(shared)
    for name in shared:
        np.testing.assert_array_equal(ours_columns[name], their_columns[name], err_msg=name)


@pytest.mark.parametrize("name", ["analogue_axis", "ornl_testbed_can"])
def test_shipped_rigs_with_devices_can_be_simulated(name: str) -> None:
    simulated = with_simulated_devices(load_rig(name))
    refuse_unusable(simulated)
    assert {device.driver for device in simulated.rig.devices.values()} == {"sim"}
    assert set(simulated.rig.signals) == set(load_rig(name).rig.signals)
    assert simulated.rig.plant == load_rig(name).rig.plant


@pytest.mark.parametrize("name", ["analogue_axis", "ornl_testbed_can"])
def test_messages_name_the_lines_of_the_file_that_the_user_has(name: str) -> None:
    """Of a mistake behind the devices, and of one in the last section."""
    loaded = load_rig(name)
    simulated = with_simulated_devices(loaded)
    for line in ("signals:", "outputs:", "interlocks:", "servo:", "plant:"):
        assert simulated.text.splitlines().index(line) == loaded.text.splitlines().index(line)
    assert simulated.text.count("\n") == loaded.text.count("\n")


def test_what_the_plant_does_not_measure_is_named() -> None:
    text = load_rig("analogue_axis").text
    lines = [line for line in text.splitlines() if not line.startswith("    reservoir_temperature: {resolution")]
    loaded = LoadedRig(rig_from_text("\n".join(lines)), "\n".join(lines), "axis.yaml")
    with pytest.raises(ConfigError, match=r"no sensor reservoir_temperature, which hydraulic_unit measures. Add plant.sensors"):
        with_simulated_devices(loaded)


def test_changes_of_the_rig_come_first() -> None:
    text = apply_overrides(load_rig("analogue_axis").text, ["signals.axis.position.max_age=7 ms"])
    simulated = with_simulated_devices(LoadedRig(rig_from_text(text), text, "axis.yaml"))
    assert simulated.rig.signals["axis.position"].max_age_s == 0.007
