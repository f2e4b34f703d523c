"""The search on the simulated testbed: an entry deleted from the rig file is found from two logs of the whole rig."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from config.loading.load import load_rig
from daemon.cli.gap.gap_demo import logged, without
from gap.find import find


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return logged(load_rig("ornl_testbed"), tmp_path_factory.mktemp("logs"), 1, lambda line: None)


def search(tmp_path: Path, logs: dict[str, Path], text: str) -> dict[str, Any]:
    model = tmp_path / "model.yaml"
    model.write_text(text)
    return find(model, [logs["fit"]], [logs["holdout"]], tmp_path / "out", lambda line: None).content


def named(content: dict[str, Any]) -> set[tuple[str, str]]:
    """The names and, where the logs cannot tell, the sets they belong to."""
    found = {(f["effect"], f["where"]) for f in content["findings"]}
    return found | {(a["effect"], a["where"]) for f in content["findings"] for a in f["look_alikes"]}


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize(
    ("effect", "where"),
    [
        pytest.param("link_flexibility", "link", marks=pytest.mark.long),  # by measurements too: measured/test_cu_arm.py
        ("coulomb_friction", "rotary"),
        pytest.param("valve_lag", "rotary", marks=pytest.mark.long),
        pytest.param("hose_compliance", "rotary", marks=pytest.mark.long),  # softer oil, far beyond its prior, would do as much
    ],
)
def test_deleted_effect_is_found(tmp_path: Path, logs: dict[str, Path], effect: str, where: str) -> None:
    content = search(tmp_path, logs, without(load_rig("ornl_testbed").text, effect, where))
    assert content["verdict"] in ("named", "ambiguous")
    assert (effect, where) in named(content)
    assert len(content["findings"]) == 1
    assert content["gap"]["holdout_after"] <= 1.2


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(1200)
def test_a_joint_without_friction_gets_it_back(tmp_path: Path, logs: dict[str, Path]) -> None:
    text = load_rig("ornl_testbed").text
    for effect in ("coulomb_friction", "stiction", "viscous_friction"):
        text = without(text, effect, "rotary")
    content = search(tmp_path, logs, text)
    assert named(content) >= {("coulomb_friction", "rotary"), ("viscous_friction", "rotary")}
    assert {where for _, where in named(content)} == {"rotary"}
    sizes = {f["effect"]: f["parameters"] for f in content["findings"]}
    assert sizes["coulomb_friction"]["friction"]["value"] == pytest.approx(105.0, rel=0.1)
    assert sizes["viscous_friction"]["coefficient"]["value"] == pytest.approx(1000.0, rel=0.1)
    assert content["gap"]["holdout_after"] <= 1.2


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_whole_rig_has_no_gap(tmp_path: Path, logs: dict[str, Path]) -> None:
    content = search(tmp_path, logs, load_rig("ornl_testbed").text)
    assert content["verdict"] == "no_gap"
    assert content["findings"] == []


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(900)
def test_jittered_constants_name_nothing(tmp_path: Path, logs: dict[str, Path]) -> None:
    text = load_rig("ornl_testbed").text
    for old, new in (
        ("hub_inertia: 11.7", "hub_inertia: 12.6"),
        ("coefficient: 1000 N", "coefficient: 930 N"),
        ("bulk_modulus: 3.0", "bulk_modulus: 2.7"),
    ):
        assert old in text
        text = text.replace(old, new)
    content = search(tmp_path, logs, text)
    assert content["verdict"] in ("parameter_mismatch", "no_gap")
    assert content["findings"] == []
