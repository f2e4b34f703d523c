"""Measured seal friction (CC0): Coulomb friction, which grows with pressure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.support.gap import measured_logs

DATA = "pneumatic_seal_friction"


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("seal", ["O-ring", "KDN"])
def test_in_the_middle_of_the_stroke_the_friction_is_coulomb_friction(tmp_path: Path, seal: str) -> None:
    """There the rod runs at 5 to 15 mm/s, and the force hardly grows with that; 3 bar is held out."""

    def middle(row: dict[str, float]) -> bool:
        return 0.006 < row["x_m"] < 0.030

    fit = measured_logs.logs(tmp_path, DATA, "seal_rig", [f"{seal}_{bar}bar" for bar in (1, 5, 7)], middle)
    holdout = measured_logs.logs(tmp_path, DATA, "seal_rig", [f"{seal}_3bar"], middle)
    content = measured_logs.findings(tmp_path, "seal_rig", fit, holdout)
    (friction,) = content["leads"]  # beside what else acts in the pressure
    assert friction["effect"] == "coulomb_friction"
    assert friction["probability"] > 0.95
    assert 5.0 < friction["parameters"]["friction"]["value"] < 7.0  # N


@pytest.fixture(scope="module")
def over_pressures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """Fitted at 1 and 7 bar, decided at 3 and 5. (At 3 and 5 bar alone friction differs by a quarter, and one name is enough.)"""
    folder = tmp_path_factory.mktemp("seal")
    fit = measured_logs.logs(folder, DATA, "seal_rig", [f"O-ring_{bar}bar" for bar in (1, 7)])
    holdout = measured_logs.logs(folder, DATA, "seal_rig", [f"O-ring_{bar}bar" for bar in (3, 5)])
    return {f["effect"]: f for f in measured_logs.findings(folder, "seal_rig", fit, holdout)["leads"]}


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_friction_grows_with_pressure_where_the_fit_logs_span_it(over_pressures: dict[str, dict[str, Any]]) -> None:
    assert over_pressures["pressure_friction"]["probability"] > 0.95
    assert not {"sensor_offset", "gravity"} & set(over_pressures)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.xfail(strict=True, raises=AssertionError, reason="0.93: viscous friction in its place, now fitted, has 0.07; see the roadmap")
def test_the_rest_of_the_friction_is_coulomb_friction(over_pressures: dict[str, dict[str, Any]]) -> None:
    assert over_pressures["coulomb_friction"]["probability"] > 0.95
