"""Explanations whose numbers logs hold can do less to look like one another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from config.loading.load import LoadedRig, rig_from_text
from daemon.cli.main import main
from gap.data.measured import load
from gap.maneuvers import next_maneuver
from gap.maneuvers.designs import designs
from gap.maneuvers.informed import informed
from gap.maneuvers.rivals import rival_of
from gap.maneuvers.separation import Rival
from tests.support.gap import axis_logs
from tests.support.gap.compared import compare


@pytest.fixture
def axis() -> LoadedRig:
    text = axis_logs.axis_text(noise_um=20.0)
    return LoadedRig(rig_from_text(text), text, "axis.yaml")


@pytest.fixture
def log(axis: LoadedRig, tmp_path: Path) -> Path:
    return axis_logs.write(tmp_path / "a.csv", axis_logs.simulated(axis.rig, 3, 6.0))


def pair(loaded: LoadedRig) -> list[Rival]:
    """A push of 2 N: one way only while it moves, or always."""
    return [
        rival_of(loaded, "asymmetric_friction", "axis", {"friction_difference": 4.0, "coefficient_difference": 0.0}),
        rival_of(loaded, "gravity", "axis", {"tilt": 2.0 / (95.1089 * 9.80665)}),
    ]


def test_a_maneuver_separates_more_beside_the_logs_that_were_fitted(axis: LoadedRig, log: Path) -> None:
    strokes = next(d for d in designs(axis.rig, ["axis"], thorough=False) if d.parameters.get("amplitude") == "8 V")
    blind = pair(axis)
    seeing = informed(axis, blind, [load(log, axis.rig)])
    without, beside = (compare(axis, *rivals, strokes.content).exact() for rivals in (blind, seeing))
    assert beside.T > 1.03 * without.T > 0.0


def test_the_command_takes_the_logs(axis: LoadedRig, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_text(axis.text)
    given: list[Sequence[Rival]] = []
    monkeypatch.setattr(next_maneuver, "next_maneuver", lambda loaded, rivals, *rest: given.append(rivals))
    for more in ([], ["--log", str(log)]):
        assert main(["gap", "next", "--rig", str(rig), "--between", "asymmetric_friction@axis", "gravity@axis", *more]) == 0
    without, beside = given
    assert [rival.earlier for rival in without] == [None, None]
    for rival in beside:
        assert rival.earlier is not None
        information, off = rival.earlier.of(rival.model)
        assert (information.diagonal() > 0.0).sum() > len(rival.model.free) / 2
        assert not off.any()


def test_a_log_without_enough_windows_is_refused(axis: LoadedRig, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    short = axis_logs.write(tmp_path / "short.csv", axis_logs.simulated(axis_logs.axis_rig(), 3, 0.5))
    arguments = ["gap", "next", "--rig", "force_axis", "--between", "asymmetric_friction@axis", "gravity@axis", "--log", str(short)]
    assert main(arguments) == 3
    assert "too few windows are left" in capsys.readouterr().err
