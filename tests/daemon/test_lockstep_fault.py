"""A run that ends in a fault is a refusal with the reason, not a crash."""

from __future__ import annotations

from pathlib import Path

import pytest

from config.errors import DaemonError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.lockstep import run_lockstep


def test_a_fault_during_a_run_says_what_it_was(tmp_path: Path) -> None:
    """A valve lag that the axis's servo was not made for: it swings up on the first steps."""
    lag = "  effects:\n    - {effect: valve_lag, where: axis, time_constant: 8 ms, damping_ratio: 0.7}\n"
    text = load_rig("force_axis").text.replace("  effects:\n", lag, 1)
    changes = {"start": {"axis": "0.125 m"}, "joint": "axis", "step": "1.4 mm", "steps": 3, "hold": "0.8 s"}
    request = {"maneuver": {"name": "staircase"}, "parameters": changes, "approach": True}
    with pytest.raises(DaemonError, match=r"axis hunting .*The servo is unstable"):
        run_lockstep(LoadedRig(rig_from_text(text), text, "rig.yaml"), [request], tmp_path)
