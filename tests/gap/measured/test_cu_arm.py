"""Measured rotary arm (University of Colorado): friction or dead band, a loop delay; a bending link, a late and a reversed sensor."""

from __future__ import annotations

from pathlib import Path

import pytest

from gap.outcome.findings import explanations
from tests.support.gap import measured_logs

DATA = "cu_rotary_arm_rigid_flex"


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_rigid_arm_gives_the_pair_and_a_loop_delay(tmp_path: Path) -> None:
    """Position feedback alone is fitted, position and rate feedback decides. Expected: the pair, then a delay of about 30 ms."""
    fit = measured_logs.logs(tmp_path, DATA, "cu_rigid_arm", [f"rigidarm_K1_{k}" for k in (6, 7, 8, 9)])
    holdout = measured_logs.logs(tmp_path, DATA, "cu_rigid_arm", [f"rigidarm_k1k3_{k}" for k in (6, 7, 8, 9)])
    content = measured_logs.findings(tmp_path, "cu_rigid_arm", fit, holdout)
    pair, delay, *_ = found = explanations(content)
    assert measured_logs.set_of(pair) == {"coulomb_friction", "valve_deadband"}
    assert measured_logs.set_of(delay) & {"transport_delay", "sensor_delay"}
    assert content["verdict"] in ("ambiguous", "unknown")
    assert not pair["confirmed"]
    late_s = next(p["value"] for f in found for key, p in f["parameters"].items() if key == "delay")
    assert 0.02 < late_s < 0.05


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("fit", "holdout", "turned"),
    [
        (["flexarm_K1_6", "flexarm_K1K2_6_-5"], ["flexarm_k1k2_6_-3"], True),
        (["flexarm_K1K2K3_6_-3_213", "flexarm_K1K2K3k4_6_-3_213_4"], ["flexarm_K1K2K3k4_6_-3_213_2", "flexarm_K1K2K3_6_-5_213"], False),
    ],
)
def test_the_flexible_arm_gives_mode_delay_and_sign(tmp_path: Path, fit: list[str], holdout: list[str], turned: bool) -> None:
    """The tip is 56 to 64 ms late on every unit; the sign of its strain gauge differs between them."""
    content = measured_logs.findings(
        tmp_path,
        "cu_flexible_arm",
        measured_logs.logs(tmp_path, DATA, "cu_flexible_arm", fit),
        measured_logs.logs(tmp_path, DATA, "cu_flexible_arm", holdout),
    )
    found = {(f["effect"], f["where"]): f for f in explanations(content)}
    assert ("link_flexibility", "link") in found
    assert (("sensor_polarity", "sensor:tip.deflection") in found) == turned
    delay = found[("sensor_delay", "sensor:tip.deflection")]["parameters"]["delay"]["value"]
    assert 0.054 < delay < 0.066
    stiffness = found[("link_flexibility", "link")]["parameters"]["bending_stiffness"]["value"]
    assert 1.6 < 1.8 * (stiffness / 0.249) ** 0.5 < 2.0  # Hz; the laboratory quotes 1.8
    tip = content["gap"]["channels"]["tip.deflection"]
    assert tip["after"] < 0.25 * tip["before"]
    assert content["where"][0]["equation"] == "link bending of link"
