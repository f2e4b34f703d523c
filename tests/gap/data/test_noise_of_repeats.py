"""Runs of one maneuver show the noise that a local fit cannot see."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gap.data.measured import load
from gap.data.noise import noise_floors
from tests.support.gap import axis_logs


def test_noise_of_long_memory_shows_between_repeats(tmp_path: Path) -> None:
    """A slow disturbance of 50 um hides from a cubic over 21 samples; two runs differ by it."""
    rig = axis_logs.axis_rig()
    columns = axis_logs.simulated(rig, 3, 6.0)
    t = columns["t_s"]
    logs = []
    for k in range(2):
        disturbed = columns["axis.position"] + 50e-6 * np.sqrt(2) * np.sin(2 * np.pi * 7 * t + 2.0 * k)
        logs.append(load(axis_logs.write(tmp_path / f"{k}.csv", {**columns, "axis.position": disturbed}), rig))
    once, twice = (noise_floors(some, rig)["axis.position"] for some in (logs[:1], logs))
    assert once < 5e-6
    difference = 50e-6 * np.sqrt(2) * 2 * np.sin(1.0)  # amplitude of the difference of two sines 2 rad apart
    assert twice == pytest.approx(difference / np.sqrt(2) / np.sqrt(2), rel=0.1)
