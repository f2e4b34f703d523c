"""Measured seal friction (CC0): Coulomb or viscous cannot be told at one speed; friction grows with pressure."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.gap import measured_logs

DATA = "pneumatic_seal_friction"


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("seal", ["O-ring", "KDN"])
def test_at_one_speed_coulomb_and_viscous_friction_are_a_pair(tmp_path: Path, seal: str) -> None:
    """Only the middle of the stroke, where the rod moves at its one speed; 3 bar is held out."""

    def middle(row: dict[str, float]) -> bool:
        return 0.006 < row["x_m"] < 0.030

    fit = measured_logs.logs(tmp_path, DATA, "seal_rig", [f"{seal}_{bar}bar" for bar in (1, 5, 7)], middle)
    holdout = measured_logs.logs(tmp_path, DATA, "seal_rig", [f"{seal}_3bar"], middle)
    content = measured_logs.findings(tmp_path, "seal_rig", fit, holdout)
    assert {"coulomb_friction", "viscous_friction"} <= measured_logs.set_of(content["findings"][0])
    assert content["verdict"] == "ambiguous"


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_friction_grows_with_pressure_where_the_fit_logs_span_it(tmp_path: Path) -> None:
    """Fitted at 1 and 7 bar, decided at 3 and 5. (At 3 and 5 bar alone friction differs by a quarter, and one name is enough.)"""
    fit = measured_logs.logs(tmp_path, DATA, "seal_rig", [f"O-ring_{bar}bar" for bar in (1, 7)])
    holdout = measured_logs.logs(tmp_path, DATA, "seal_rig", [f"O-ring_{bar}bar" for bar in (3, 5)])
    content = measured_logs.findings(tmp_path, "seal_rig", fit, holdout)
    found = {f["effect"]: f for f in content["leads"]}
    assert found["pressure_friction"]["probability"] > 0.95
    assert found["coulomb_friction"]["probability"] > 0.95
    assert not {"sensor_offset", "gravity"} & set(found)
