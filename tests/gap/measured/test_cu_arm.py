"""Measured rotary arm (University of Colorado): friction or dead band, a loop delay; a bending link, a late and a reversed sensor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from gap.outcome.findings import explanations
from tests.support.gap import measured_logs

DATA = "cu_rotary_arm_rigid_flex"


UNITS = pytest.mark.parametrize(
    ("fit", "holdout", "turned"),
    [
        (["flexarm_K1_6", "flexarm_K1K2_6_-5"], ["flexarm_k1k2_6_-3"], True),
        (["flexarm_K1K2K3_6_-3_213", "flexarm_K1K2K3k4_6_-3_213_4"], ["flexarm_K1K2K3k4_6_-3_213_2", "flexarm_K1K2K3_6_-5_213"], False),
    ],
)


def searched(folder: Path, rig: str, fit: list[str], holdout: list[str]) -> dict[str, Any]:
    logs = [measured_logs.logs(folder, DATA, rig, names) for names in (fit, holdout)]
    return measured_logs.findings(folder, rig, *logs)


def rigid_arm(folder: Path) -> dict[str, Any]:
    """Position feedback alone is fitted, position and rate feedback decides."""
    fit, holdout = ([f"rigidarm_{loop}_{k}" for k in (6, 7, 8, 9)] for loop in ("K1", "k1k3"))
    return searched(folder, "cu_rigid_arm", fit, holdout)


def late_and_soft_as_known(found: dict[tuple[str, str], dict[str, Any]]) -> None:
    """The delay of the tip's sensor, and the frequency of the link's first mode."""
    assert 0.054 < found[("sensor_delay", "sensor:tip.deflection")]["parameters"]["delay"]["value"] < 0.066
    stiffness = found[("link_flexibility", "link")]["parameters"]["bending_stiffness"]["value"]
    assert 1.6 < 1.8 * (stiffness / 0.249) ** 0.5 < 2.0  # Hz; the laboratory quotes 1.8


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_rigid_arm_has_coulomb_friction_and_a_loop_delay(tmp_path: Path) -> None:
    """Beside what else acts there, which no name of the library explains. A late valve or a late sensor: the shares are those of both."""
    content = rigid_arm(tmp_path)
    friction, delay = content["leads"]
    assert (friction["effect"], content["verdict"]) == ("coulomb_friction", "unknown")
    assert measured_logs.set_of(delay) >= {"transport_delay", "sensor_delay"}
    assert 0.02 < delay["parameters"]["delay"]["value"] < 0.05
    assert not friction["confirmed"]


@pytest.mark.slow
@pytest.mark.timeout(900)
@UNITS
def test_the_flexible_arm_has_mode_delay_and_sign(tmp_path: Path, fit: list[str], holdout: list[str], turned: bool) -> None:
    """Each more probable than not; on the second unit a doubtful scale of the same sensor beside them."""
    content = searched(tmp_path, "cu_flexible_arm", fit, holdout)
    found = {(f["effect"], f["where"]): f for f in explanations(content)}
    true = {("link_flexibility", "link"), ("sensor_delay", "sensor:tip.deflection")}
    true |= {("sensor_polarity", "sensor:tip.deflection")} if turned else set()
    assert set(found) - {("sensor_scale", "sensor:tip.deflection")} == true
    assert all(found[one]["probability"] > 0.8 for one in true)
    assert not any(one["confirmed"] for one in found.values())  # much is left
    late_and_soft_as_known(found)
