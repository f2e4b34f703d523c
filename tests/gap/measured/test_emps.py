"""Measured data with a published answer: Coulomb friction, then asymmetric viscous friction, then nothing more.

A. Janot, M. Gautier, M. Brunot: 20.39 N; 166.7 and 240.4 N s/m.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from config.loading.load import load_rig
from gap.find import find
from gap.settings import Settings
from tests.support.gap import emps_logs

COULOMB_N = 20.39
DIFFERENCE_N_S_PER_M = 166.7 - 240.4
WITHOUT_OFFSET, WITH_OFFSET = "no offset in the rig file", "the rig file's offset"
FIVE_PER_CENT_OFF = pytest.mark.xfail(strict=False, raises=AssertionError, reason="−77.6 N s/m, 5.3 % off; see the roadmap")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The search's folder, by what the rig file says of the offset."""
    folders = {}
    for name in (WITHOUT_OFFSET, WITH_OFFSET):
        folder = tmp_path_factory.mktemp("emps")
        fit_log, holdout = emps_logs.logs(folder)
        folders[name] = folder / "out"
        rig = emps_logs.frictionless(folder, name == WITH_OFFSET)
        find(rig, [fit_log], [holdout], folders[name], lambda line: None, Settings(propose=False))
    return folders


def content(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "findings.json").read_text()))


def named(folder: Path) -> dict[str, bool]:
    """Every effect named, and whether it is confirmed."""
    return {finding["effect"]: finding["confirmed"] for finding in content(folder)["findings"]}


def parameter(folder: Path, effect: str, name: str) -> dict[str, Any]:
    (one,) = (finding for finding in content(folder)["findings"] if finding["effect"] == effect)
    return dict(one["parameters"][name])


@pytest.mark.slow
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, WITH_OFFSET])
def test_coulomb_and_asymmetric_friction_are_named_and_the_gap_closes(found: dict[str, Path], offset: str) -> None:
    """What else is said is tentative."""
    said, names = content(found[offset]), named(found[offset])
    assert {"coulomb_friction", "asymmetric_friction"} <= set(names)
    assert {name for name, confirmed in names.items() if confirmed} <= {"coulomb_friction", "asymmetric_friction"}
    assert said["gap"]["channels"]["axis.position"]["after"] <= 26e-6
    improved = load_rig(found[offset] / "rig.yaml").rig.plant
    assert improved is not None
    assert {(e.effect, e.where) for e in improved.effects} >= {("coulomb_friction", "axis"), ("asymmetric_friction", "axis")}
    assert "<img" in (found[offset] / "report.html").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, WITH_OFFSET])
def test_the_fit_log_has_the_friction_within_five_per_cent_of_the_authors(found: dict[str, Path], offset: str) -> None:
    friction = parameter(found[offset], "coulomb_friction", "friction")
    assert friction["fit_logs"]["value"] == pytest.approx(COULOMB_N, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, pytest.param(WITH_OFFSET, marks=FIVE_PER_CENT_OFF)])
def test_the_fit_log_has_the_difference_within_five_per_cent_of_the_authors(found: dict[str, Path], offset: str) -> None:
    difference = parameter(found[offset], "asymmetric_friction", "coefficient_difference")
    assert difference["fit_logs"]["value"] == pytest.approx(DIFFERENCE_N_S_PER_M, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, WITH_OFFSET])
def test_the_fit_logs_interval_holds_the_authors_difference(found: dict[str, Path], offset: str) -> None:
    low, high = parameter(found[offset], "asymmetric_friction", "coefficient_difference")["fit_logs"]["ci95"]
    assert low < DIFFERENCE_N_S_PER_M < high


@pytest.mark.slow
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, WITH_OFFSET])
def test_coulomb_friction_is_confirmed(found: dict[str, Path], offset: str) -> None:
    assert named(found[offset])["coulomb_friction"]


@pytest.mark.slow
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, WITH_OFFSET])
def test_asymmetric_friction_is_confirmed(found: dict[str, Path], offset: str) -> None:
    assert named(found[offset])["asymmetric_friction"]


@pytest.mark.slow
@pytest.mark.xfail(strict=False, raises=AssertionError, reason="without the offset 21.61 N, 6.0 % off; with it 21.75; see the roadmap")
@pytest.mark.parametrize("offset", [WITHOUT_OFFSET, WITH_OFFSET])
def test_all_logs_have_the_friction_within_five_per_cent_of_the_authors(found: dict[str, Path], offset: str) -> None:
    assert parameter(found[offset], "coulomb_friction", "friction")["value"] == pytest.approx(COULOMB_N, rel=0.05)
