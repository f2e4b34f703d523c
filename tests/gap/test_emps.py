"""Measured data with a published answer: Coulomb friction, then asymmetric viscous friction, then nothing more."""

from __future__ import annotations

import json
from pathlib import Path

import emps_logs
import pytest

from config.load import load_rig
from gap.find import find

MISSED = "21.45 N, the authors 20.39: 5.2 % off, 5 % is wanted; see the roadmap"
BESIDE_AN_OFFSET = "beside the rig file's offset the search gives about -66 N s/m, the authors -73.7: more than 5 % away; see the roadmap"


@pytest.mark.slow
@pytest.mark.parametrize(
    "keep_offset",
    [pytest.param(False, marks=pytest.mark.xfail(reason=MISSED)), pytest.param(True, marks=pytest.mark.xfail(reason=BESIDE_AN_OFFSET))],
)
def test_emps_gives_coulomb_then_asymmetric_friction_then_stops(tmp_path: Path, keep_offset: bool) -> None:
    fit_log, holdout = emps_logs.logs(tmp_path)
    out = tmp_path / "out"
    find(emps_logs.frictionless(tmp_path, keep_offset), [fit_log], [holdout], out, lambda line: None)
    content = json.loads((out / "findings.json").read_text())
    assert [f["effect"] for f in content["findings"]] == ["coulomb_friction", "asymmetric_friction"]
    coulomb, asymmetric = content["findings"]
    # A. Janot, M. Gautier, M. Brunot: 20.39 N; 166.7 and 240.4 N s/m
    assert coulomb["parameters"]["friction"]["value"] == pytest.approx(20.39, rel=0.05)
    assert asymmetric["parameters"]["coefficient_difference"]["value"] == pytest.approx(166.7 - 240.4, rel=0.05)
    assert content["gap"]["channels"]["axis.position"]["after"] <= 26e-6
    improved = load_rig(out / "rig.yaml")
    assert {(e.effect, e.where) for e in improved.rig.plant.effects} >= {("coulomb_friction", "axis"), ("asymmetric_friction", "axis")}  # type: ignore[union-attr]
    assert "<img" in (out / "report.html").read_text()
