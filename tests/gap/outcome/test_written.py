"""What is written into the rig file, by the verdict, and that the table of constants says the same numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, rig_from_text
from daemon.cli.gap.gap_command import summary
from gap.data.measured import Measured, on_grid
from gap.find import search_gap
from gap.fitting.evaluation import evaluate, mean_cost
from gap.fitting.fit import covariance, fit
from gap.fitting.model import Free, Model
from gap.fitting.nuisance import nuisances
from gap.outcome.found import Found
from gap.outcome.model_file import improved, with_effect_line
from gap.outcome.names import Fitted
from gap.outcome.verdict import Verdict
from gap.outcome.written import Writer
from gap.report.report import write_report
from gap.settings import Settings
from tests.gap.remainder.test_kept_remainder import cogging, logged
from tests.support.gap import axis_logs
from tests.support.gap.finished_search import finished, quiet
from tests.support.gap.written_constants import differing, in_file

MASS = "plant.joints.axis.mass"


@pytest.mark.slow
def test_unknown_writes_the_best_constants_and_no_names(tmp_path: Path) -> None:
    """A mass that is 25 % off and a force that no effect of the library has."""
    text = axis_logs.axis_text().replace("mass: 95.1089 kg", "mass: 76 kg  # [A] guessed;")
    found = search_gap(*with_cogging(text), quiet, Settings(propose=False))
    assert found.verdict.word == "unknown"
    assert "The improved rig file has the best constants and no names" in found.verdict.why
    assert found.improved_text.count("effect:") == text.count("effect:")
    assert found.content["findings"] == []
    gap = found.content["gap"]
    assert gap["holdout_after"] < 0.2 * gap["holdout_before"]
    assert same_numbers(found, tmp_path)
    mass = in_file(tmp_path / "rig.yaml", MASS)
    assert mass is not None
    assert mass[0] == pytest.approx(95.1089, rel=0.08)  # the force without a name takes its share


def with_cogging(text: str) -> tuple[LoadedRig, list[Measured], list[Measured]]:
    """The rig file with a log to fit and one to hold out, of an axis with a force that no effect of the library has."""
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = [on_grid(Path(f"{k}.csv"), logged(k, lambda x, v: 0.25 * cogging(x, v) - 20.39 * float(np.tanh(v / 1e-3))), loaded.rig, str(k))
            for k in (11, 12)]  # fmt: skip
    return loaded, logs[:1], logs[1:]


def same_numbers(found: Found, folder: Path) -> bool:
    (folder / "rig.yaml").write_text(found.improved_text)
    return differing(found.content, folder / "rig.yaml") == []


@pytest.mark.parametrize(("word", "names", "changes"), [("named", True, True), ("unknown", False, True), ("no_gap", False, False)])
def test_the_verdict_decides_what_is_written(tmp_path: Path, word: str, names: bool, changes: bool) -> None:
    """A search that has taken Coulomb friction and a dead band: under `unknown` neither stands in the file."""
    state = finished(tmp_path, 0.02)
    model = state.current.model
    half_width = 1.96 * np.sqrt(np.diag(covariance(state.current, state.costs)))
    loaded = LoadedRig(axis_logs.axis_rig("coulomb_friction"), axis_logs.axis_text("coulomb_friction"), "axis.yaml")
    nominal = tuple(evaluate(e, state.nominal, state.costs) for e in state.holdouts)
    alone = fit(state.nominal, state.experiments, state.costs).model
    file = Writer(loaded, state, Fitted(model, half_width), nominal, alone).file(Verdict(word, "", True))
    assert ("coulomb_friction" in file.text) == names
    assert (file.text != loaded.text) == changes
    assert mean_cost(file.seen) <= mean_cost(nominal)
    assert rig_from_text(file.text).plant is not None


@pytest.mark.slow
def test_under_unknown_nothing_is_found_that_the_file_has_not(tmp_path: Path) -> None:
    """The file lacks a friction, and a force acts that no effect of the library has. What helps is told apart from what is found; terminal
    and page say that the file does not have it."""
    text = axis_logs.axis_text("coulomb_friction")
    found = search_gap(*with_cogging(text), quiet, Settings(propose=False))
    assert found.verdict.word == "unknown"
    assert found.content["findings"] == []
    assert "coulomb_friction" in [item["effect"] for item in found.content["leads"]]
    assert found.improved_text.count("effect:") == text.count("effect:")
    found.content["unused_logs"] = []
    assert "not in the file: coulomb_friction at axis" in summary(found, tmp_path)
    write_report(found, tmp_path / "report.html")
    assert "coulomb_friction at axis (not named, not in the file)" in (tmp_path / "report.html").read_text()


def test_a_constant_keeps_the_unit_it_was_stated_in_and_a_default_is_put_in() -> None:
    text = axis_logs.axis_text().replace("mass: 95.1089 kg", "mass: 209.68 lb").replace("      bristle_fade: 1 mm/s            # [A]\n", "")
    assert "bristle_fade" not in text
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    free = next(f for f in nuisances(loaded, frozenset({"axis.position"})) if f.key == MASS)
    unwritten = Free(("joints", "axis", "bristle_fade"), "plant.joints.axis.bristle_fade", "m/s", 0.01, 0.001, 0.0, 1.0, True, "A")
    model = Model(loaded.rig, (free, unwritten), np.array([100.0, 0.0123]))
    new = improved(text, model, ())
    lines = set(new.splitlines()) - set(text.splitlines())
    assert any("mass: 220.462 lb" in line and "[gap] mass was 209.68 lb" in line for line in lines)
    assert any("bristle_fade: 0.0123 m/s" in line and "[gap] bristle_fade was 0.01 m/s by default" in line for line in lines)
    plant = rig_from_text(new).plant
    assert plant is not None
    assert plant.joints["axis"].bristle_fade == pytest.approx(0.0123)
    assert plant.joints["axis"].mass_kg == pytest.approx(100.0, rel=1e-5)  # type: ignore[union-attr]


@pytest.mark.parametrize("ends", ["", "\n", "  # [B]", "\r\n"])
def test_an_effect_stands_in_the_file_whatever_its_last_line_ends_with(ends: str) -> None:
    """Behind a last line without an end it once stood in that line's comment."""
    text = axis_logs.axis_text().rstrip("\n").rpartition("  #")[0] + ends
    added = rig_from_text(with_effect_line(text, "- {effect: gravity, where: axis, tilt: 0.1 deg}"))
    before = rig_from_text(text)
    assert added.plant is not None
    assert before.plant is not None
    assert [effect.effect for effect in added.plant.effects] == [*(effect.effect for effect in before.plant.effects), "gravity"]
