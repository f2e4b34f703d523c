"""`gap next --findings`: of names and look-alikes those that the rig file lacks are told apart; a number that has changed is a constant."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from daemon.cli.main import main
from gap.maneuvers import next_maneuver
from gap.maneuvers.rivals import NONE
from gap.maneuvers.separation import Rival
from tests.support.gap import axis_logs

FRICTION = "plant.effects.0.friction"
CHANGED = {
    "effect": "coulomb_friction", "where": "axis", "stated": 20.39, "value": 61.0, "confirmed": True,
    "parameters": {"friction": {"value": 61.0, "unit": "N"}}, "look_alikes": [],
}  # fmt: skip
DEAD_BAND = {"effect": "valve_deadband", "where": "axis", "parameters": {"overlap": {"value": 0.02, "unit": ""}}}
GRAVITY = {"effect": "gravity", "where": "axis", "parameters": {"tilt": {"value": 0.01, "unit": "rad"}}}


def compared(
    folder: Path, findings: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Sequence[Rival]:
    """The explanations that the command asks about; none where it refuses."""
    (folder / "rig.yaml").write_text(axis_logs.axis_text())
    content = {"findings": findings, "gap": {"channels": {"axis.position": {}}}, "parameters": {FRICTION: {"value": 61.0}}}
    (folder / "findings.json").write_text(json.dumps(content))
    given: list[Sequence[Rival]] = [[]]
    monkeypatch.setattr(next_maneuver, "next_maneuver", lambda loaded, rivals, *rest: given.append(rivals))
    exit_status = main(["gap", "next", "--rig", str(folder / "rig.yaml"), "--findings", str(folder / "findings.json")])
    assert exit_status == 0 or "leave nothing in doubt" in capsys.readouterr().err
    return given[-1]


def test_a_tentative_name_is_told_from_none_beside_the_changed_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tentative = GRAVITY | {"confirmed": False, "look_alikes": []}
    rivals = compared(tmp_path, [CHANGED, tentative], monkeypatch, capsys)
    assert [rival.name for rival in rivals] == ["gravity at axis", NONE]
    for rival in rivals:
        friction = next(k for k, free in enumerate(rival.model.free) if free.key == FRICTION)
        assert rival.model.theta[friction] == 61.0


def test_changed_numbers_among_look_alikes_are_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    unclear = GRAVITY | {"confirmed": False, "look_alikes": [CHANGED, DEAD_BAND]}
    assert [rival.name for rival in compared(tmp_path, [unclear], monkeypatch, capsys)] == ["gravity at axis", "valve_deadband at axis"]


def test_a_changed_number_by_itself_leaves_nothing_to_be_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compared(tmp_path, [CHANGED | {"confirmed": False}], monkeypatch, capsys) == []


@pytest.mark.parametrize("text", ["no JSON", "[1]", '{"findings": []}'])
def test_a_file_that_is_no_findings_is_unusable_data(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "findings.json"
    path.write_text(text)
    assert main(["gap", "next", "--rig", "force_axis", "--findings", str(path)]) == 3
    said = capsys.readouterr().err.splitlines()
    assert said[0].startswith(f"longreach: {path}: this is no findings.json")
    assert said[1] == "next: longreach gap find --help"


def test_findings_of_another_rig_are_refused_and_those_that_name_none_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both rigs have a joint `axis`: every name and number would fit."""
    path = tmp_path / "findings.json"
    asked: list[Sequence[Rival]] = []
    monkeypatch.setattr(next_maneuver, "next_maneuver", lambda loaded, rivals, *rest: asked.append(rivals))
    tentative = GRAVITY | {"confirmed": False, "look_alikes": []}
    content = {"findings": [tentative], "gap": {"channels": {"axis.position": {}}}, "parameters": {}}
    for about, status in (({"rig": "analogue_axis"}, 3), ({"rig": "force_axis"}, 0), ({}, 0)):
        path.write_text(json.dumps(content | about))
        assert main(["gap", "next", "--rig", "force_axis", "--findings", str(path)]) == status
    assert len(asked) == 2
    assert "the findings are of another rig: analogue_axis (limit: force_axis)" in capsys.readouterr().err


def test_the_command_named_next_is_one_that_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The shipped rigs have friction already: what is named next must be effects that they lack."""
    given: list[Sequence[Rival]] = []
    monkeypatch.setattr(next_maneuver, "next_maneuver", lambda loaded, rivals, *rest: given.append(rivals))
    assert main(["gap", "next", "--rig", "force_axis"]) == 1
    *_, last = capsys.readouterr().err.splitlines()
    assert main(last.removeprefix("next: longreach ").split()) == 0
    assert len(given[0]) == 2


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("coulomb_friction@axis", "the rig file has this effect already: coulomb_friction@axis. Take its line out of a copy of the file"),
        ("gravity@axle", "the effect has no such place here: gravity@axle. Possible: gravity@axis."),
        (
            "gravitation@axis",
            "no such effect can be missing here: gravitation@axis. Nearest is gravity. Possible: asymmetric_friction",
        ),
    ],
)
def test_what_cannot_be_added_is_refused_with_what_can(name: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_text(axis_logs.axis_text())
    assert main(["gap", "next", "--rig", str(rig), "--between", name, "none"]) == 1
    assert told in capsys.readouterr().err
