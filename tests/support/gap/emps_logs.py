"""The measured EMPS logs and a rig file of that axis without friction, for tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from config.loading.load import load_rig
from recording.importing.ingest import ingest
from tests.support.measured_data import EMPS


def logs(folder: Path) -> tuple[Path, Path]:
    """Fit and hold-out log; the test is skipped where the data are absent."""
    names = ("emps_estimation", "emps_pulses_test")
    if not all((EMPS / f"{name}.csv").exists() for name in names):
        pytest.skip("the measured EMPS data are not beside the project (../shared/data/emps)")
    for name in names:
        ingest(EMPS / f"{name}.csv", "emps", folder / f"{name}.mcap")
    return folder / f"{names[0]}.mcap", folder / f"{names[1]}.mcap"


def frictionless(folder: Path, keep_offset: bool = False) -> Path:
    """force_axis with mass, drive and viscous friction only."""
    gone = ("coulomb_friction",) if keep_offset else ("coulomb_friction", "valve_null_bias")
    lines = [line for line in load_rig("force_axis").text.splitlines(keepends=True) if not any(name in line for name in gone)]
    path = folder / "axis.yaml"
    path.write_text("".join(lines))
    return path
