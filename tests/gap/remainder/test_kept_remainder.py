"""The unnamed remainder put into the rig file: a force that no effect of the library has, in a machine integrated here by itself."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.cli.main import main
from gap.data.experiments import experiments_of
from gap.data.measured import load, on_grid
from gap.fitting.evaluation import Evaluation
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.outcome.search_state import SearchState, opening_state
from gap.remainder.kept_remainder import kept_remainder
from gap.remainder.remainder import remainder
from gap.remainder.remainder_table import tables
from gap.report.kept_sentence import kept_sentence
from gap.settings import Settings
from sim_backend.effects.unnamed_remainder import UnnamedRemainder
from tests.support.gap import axis_logs

PERIOD_S, CUTS = 1e-3, 10
MASS_KG, GAIN_N_PER_V, DAMPING, OFFSET_N = 95.1089, 35.1507, 203.5, -0.00899 * 351.507
Force = Callable[[float, float], float]
MODEL = axis_logs.axis_text("coulomb_friction")


def cogging(position: float, velocity: float) -> float:
    """The load is pulled to places 0.12 m apart, as by a magnet: nothing in the library depends on the position so."""
    return -30.0 * float(np.sin(2 * np.pi * position / 0.12))


def rough_place(position: float, velocity: float) -> float:
    """The file's 20.39 N of friction, and more about 0.13 m."""
    return -(20.39 + rubbing(position)) * float(np.tanh(velocity / 1e-3))


def rubbing(position: float) -> float:
    return 30.0 * float(np.exp(-(((position - 0.13) / 0.02) ** 2)))


def logged(seed: int, force: Force) -> axis_logs.Columns:
    """12 s of M x'' = gain u + offset − B x' + force, by small symplectic steps; 2 um of noise."""
    t = PERIOD_S * np.arange(12000)
    draw = np.random.default_rng(seed)
    command = 0.09 + sum(draw.uniform(0.9, 1.6) * np.sin(2 * np.pi * f * (t + draw.uniform(0, 3))) for f in draw.uniform(0.7, 2.2, 3))
    x, v, h, positions = 0.12, 0.0, PERIOD_S / CUTS, np.empty(t.size)
    for k, drive_N in enumerate(GAIN_N_PER_V * command + OFFSET_N):
        positions[k] = x
        for _ in range(CUTS):
            v += h * (drive_N - DAMPING * v + force(x, v)) / MASS_KG
            x += h * v
    return {"t_s": t, "axis.position": positions + 2e-6 * draw.normal(size=t.size), "axis.command_V": command}


def opened(
    folder: Path, of_fit: Force, of_holdout: Force, text: str = MODEL, seeds: tuple[int, int] = (11, 12)
) -> tuple[SearchState, tuple[Evaluation, ...], dict[str, Any]]:
    """A search before its first effect, the hold-out with the rig file as it is, and what that leaves."""
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    paths = [axis_logs.write(folder / f"{k}.csv", logged(k, force)) for k, force in zip(seeds, (of_fit, of_holdout), strict=True)]
    fitted, held = ([load(path, loaded.rig)] for path in paths)
    names, experiments, holdouts = experiments_of(loaded, fitted, held, Settings(workers=1))
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    state = opening_state(model, experiments, holdouts, frozenset(names), lambda line: None)
    rest = remainder(state.seen, state.seen, names, loaded.rig)
    assert rest is not None
    return state, state.seen, rest


@pytest.mark.slow
def test_a_force_that_has_no_name_is_kept_with_its_true_size(tmp_path: Path) -> None:
    state, nominal, rest = opened(tmp_path, cogging, cogging)
    text, kept = kept_remainder(MODEL, state, rest, nominal, lambda line: None)
    assert kept["kept"]
    assert kept["holdout_before"] > 1000
    assert kept["holdout_after"] < 10
    assert not kept["drives"]
    plant = rig_from_text(text).plant
    assert plant is not None
    table = plant.effects[-1]
    assert isinstance(table, UnnamedRemainder)
    assert table.variable == "position"
    assert table.force == pytest.approx([cogging(x, 0.0) for x in table.knots], abs=1.5)
    (line,) = set(text.splitlines()) - set(MODEL.splitlines())
    assert "[gap] unnamed remainder, not physics: force seen over axis.position" in line
    assert "noise floors" in line
    assert "no physics: the hold-out falls from" in kept_sentence({"kept": kept})


@pytest.mark.slow
def test_friction_that_changes_with_the_position_is_kept_as_friction(tmp_path: Path) -> None:
    model = axis_logs.axis_text()
    state, nominal, rest = opened(tmp_path, rough_place, rough_place, model, (16, 14))
    text, kept = kept_remainder(model, state, rest, nominal, lambda line: None)
    assert kept["holdout_after"] < 0.2 * kept["holdout_before"]
    plant = rig_from_text(text).plant
    assert plant is not None
    table = plant.effects[-1]
    assert isinstance(table, UnnamedRemainder)
    assert table.friction == pytest.approx([rubbing(x) for x in table.position], abs=8.0)
    assert "a table of friction over position" in kept_sentence({"kept": kept})


@pytest.mark.slow
def test_what_the_holdout_does_not_have_is_not_kept(tmp_path: Path) -> None:
    """The fit log's force is not in the hold-out: a table of it makes that worse."""
    state, nominal, _ = opened(tmp_path, cogging, lambda x, v: -cogging(x, v))
    text, kept = kept_remainder(MODEL, state, {"discrepancy": None}, nominal, lambda line: None)
    assert text == MODEL
    assert not kept["kept"]
    assert "no clear fall" in kept["why"]
    assert kept["holdout_after"] > kept["holdout_before"]


def log_state(rig_text: str, columns: dict[str, np.ndarray]) -> Any:
    """As much of a search as is looked at before anything is fitted."""
    log = on_grid(Path("log.csv"), columns, rig_from_text(rig_text), "")
    return SimpleNamespace(experiments=[SimpleNamespace(log=log)])


def why(rig_text: str, columns: dict[str, np.ndarray], found: dict[str, Any] | None = None) -> str:
    told: list[str] = []
    text, kept = kept_remainder(rig_text, log_state(rig_text, columns), {"discrepancy": found}, [], told.append)
    assert text == rig_text
    assert not kept["kept"]
    assert kept["why"] in told[0]
    return str(kept["why"])


def test_without_chamber_pressures_it_says_which_sensors_are_lacking() -> None:
    t = 1e-3 * np.arange(4000)
    moved = {"rotary.position": 0.1 * np.sin(t), "prismatic.position": 1.0 + 0.1 * np.sin(t)}
    columns = {"t_s": t, **moved, "rotary.command_V": np.cos(t), "prismatic.command_V": np.cos(t)}
    said = why(load_rig("ornl_testbed").text, columns)
    assert "rotary: the drive's force is not known without rotary.pressure_a and rotary.pressure_b" in said
    assert "prismatic: the drive's force is not known without prismatic.pressure_a and prismatic.pressure_b" in said


def test_one_table_a_joint_and_only_forces() -> None:
    columns = logged(11, cogging)
    table = "    - {effect: unnamed_remainder, where: axis, position: [0 m, 0.2 m], force: [0 N, 1 N]}\n"
    assert "has an unnamed_remainder at axis already; delete it" in why(MODEL + table, columns)
    assert "it is in the link bending of link" in why(MODEL, columns, {"equation": "link bending of link"})


def test_the_curve_of_an_imbalance_becomes_a_table_of_the_missing_force() -> None:
    """Opposite sign, knots apart, only the joint's own variables; a sign becomes a jump as wide as the bristles take to fade."""
    rig = rig_from_text(MODEL)
    at = [-0.2, -0.1, -0.001, 0.0, 0.001, 0.05, 0.1, 0.15, 0.2]
    curves = [
        {"input": "axis.velocity", "share": 0.9, "at": at, "value": [10 * v for v in at]},
        {"input": "time", "share": 0.3, "at": at, "value": at},
        {"input": "sign of axis.velocity", "share": 0.1, "at": [-1.0, 1.0], "value": [-5.0, 4.0]},
    ]
    smooth, jump = tables({"equation": "force balance of axis", "carried_by": curves}, rig)
    assert smooth.variable == "velocity"
    assert np.all(np.diff(smooth.knots) > 0.02 * 0.4)
    assert smooth.force == pytest.approx(-10 * smooth.knots)
    assert list(jump.knots) == [-0.001, 0.001]
    assert list(jump.force) == [5.0, -4.0]


@pytest.mark.slow
def test_the_whole_search_keeps_it_when_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / "axis.yaml"
    model.write_text(MODEL)
    fit, hold = (str(axis_logs.write(tmp_path / f"{k}.csv", logged(k, cogging))) for k in (11, 12))
    options = ["--rig", str(model), "--log", fit, "--holdout", hold, "--out", str(tmp_path / "out")]
    assert main(["gap", "find", *options, "--keep-remainder"]) == 0
    assert "unnamed_remainder at axis, a table of force over position" in capsys.readouterr().out
    content = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert content["verdict"] == "unknown"
    assert not any(finding["confirmed"] for finding in content["findings"])
    assert "unnamed_remainder" not in {finding["effect"] for finding in content["findings"]}
    kept = content["remainder"]["kept"]
    assert kept["kept"]
    assert kept["holdout_before"] == pytest.approx(content["gap"]["holdout_after"])
    assert kept["holdout_after"] < 0.01 * kept["holdout_before"]
    assert "unnamed remainder, not physics" in load_rig(tmp_path / "out" / "rig.yaml").text
    assert "is in the improved rig file as unnamed_remainder at axis" in (tmp_path / "out" / "report.html").read_text()
