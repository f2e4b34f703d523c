"""The length of the windows follows from noise and force, by closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.data.measured import Measured, on_grid
from gap.data.window_length import LONGEST_S, window_length_s


def log(rig_name: str, joint: str, rms_V: float) -> Measured:
    t = 0.001 * np.arange(3000)
    command = np.sqrt(2) * rms_V * np.sin(2 * np.pi * 2 * t)
    return on_grid(Path("log.csv"), {"t_s": t, f"{joint}.position": 0.1 + 0 * t, f"{joint}.command_V": command}, load_rig(rig_name).rig, "")


def test_a_hundredth_of_the_force_bends_the_position_visibly() -> None:
    """Twice the force, or half the noise, allows windows shorter by √2; checked against the bend itself."""
    rig, sigma = load_rig("force_axis").rig, 5e-6
    length = window_length_s(rig, [log("force_axis", "axis", 2.0)], {"axis.position": sigma})
    t = np.linspace(0, length, 2001)
    bend = 0.01 * 35.1507 * 2.0 / 95.1089 * t**2 / 2
    left = bend - np.polyval(np.polyfit(t, bend, 1), t)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(4.5 * sigma, rel=0.06)
    assert 0.2 < length < LONGEST_S
    stronger = window_length_s(rig, [log("force_axis", "axis", 4.0)], {"axis.position": sigma})
    assert stronger == pytest.approx(length / np.sqrt(2), abs=0.006)


def test_it_stays_between_its_bounds() -> None:
    rig = load_rig("force_axis").rig
    assert window_length_s(rig, [log("force_axis", "axis", 2.0)], {"axis.position": 1e-7}) == 0.2
    assert window_length_s(rig, [log("force_axis", "axis", 2.0)], {"axis.position": 1e-3}) == LONGEST_S
    assert window_length_s(rig, [log("force_axis", "axis", 0.0)], {"axis.position": 1e-3}) == 0.2
    assert window_length_s(load_rig("ornl_testbed").rig, [], {}) == 0.4
