"""Constants held by the tag [fixed], or 0: the fit leaves them alone, and says where the logs want them."""

from __future__ import annotations

import datetime
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.checking.check import check_rig
from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.parsing.provenance import tag_of
from config.parsing.yaml_tree import parse
from gap.data.experiments import experiments_of
from gap.data.measured import on_grid
from gap.fitting.evaluation import evaluate
from gap.fitting.fit import fit
from gap.fitting.model import Model
from gap.fitting.nuisance import held, nuisances
from gap.outcome.held_constants import HeldConstant, held_constants
from gap.outcome.search_state import opening_state
from gap.settings import Settings
from tests.support.gap import axis_logs
from tests.support.gap.finished_search import quiet

CHANNELS = frozenset({"axis.position"})
DAMPING = "plant.effects.1.coefficient"


def fixed(text: str, line: str) -> str:
    """The text with [fixed] in the comment of the line that holds `line`."""
    rows = text.splitlines()
    number = next(k for k, row in enumerate(rows) if line in row)
    rows[number] = rows[number].replace("# [", "# [fixed] [", 1)
    return "\n".join(rows) + "\n"


def asked(text: str, truth: str) -> list[HeldConstant]:
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = [on_grid(Path(f"{k}.csv"), axis_logs.simulated(rig_from_text(truth), k, 6.0), loaded.rig, str(k)) for k in (11, 12)]
    names, few, holdouts = experiments_of(loaded, logs[:1], logs[1:], Settings(workers=1))
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    state = opening_state(model, few, holdouts, frozenset(names), quiet)
    done = fit(model, state.experiments, state.costs)
    state = replace(state, current=done, seen=tuple(evaluate(e, done.model, state.costs) for e in holdouts))
    assert all(item.key not in {f.key for f in held(loaded, CHANNELS)} for item in state.current.model.free)
    return held_constants(loaded, state, quiet)


def test_a_fixed_constant_is_not_free_and_the_logs_say_where_they_want_it() -> None:
    text, truth = axis_logs.axis_text(), axis_logs.axis_text().replace("coefficient: 203.5", "coefficient: 260")
    assert DAMPING in {free.key for free in nuisances(LoadedRig(rig_from_text(text), text, "x"), CHANNELS)}
    (found, *_) = asked(fixed(text, "viscous_friction"), truth)
    assert (found.free.key, found.as_dict()["because"]) == (DAMPING, "fixed")
    assert found.value == pytest.approx(260.0, rel=0.03)
    assert found.after < found.before - 0.02


def test_a_fixed_constant_that_is_right_is_not_asked_for() -> None:
    assert asked(fixed(axis_logs.axis_text(), "viscous_friction"), axis_logs.axis_text()) == []


def test_a_constant_of_0_that_the_logs_want_is_said() -> None:
    """The offset of the drive, which the rig file has as 0."""
    text = axis_logs.axis_text().replace("bias: -0.00899}", "bias: 0.0}")
    assert "bias: 0.0}" in text
    (found, *_) = asked(text, axis_logs.axis_text())
    assert found.free.key.endswith(".bias")
    assert found.as_dict()["because"] == "0"
    assert found.value == pytest.approx(-0.00899, rel=0.05)


def test_a_0_that_stands_for_none_is_not_asked_for() -> None:
    """A bandwidth of 0 says that there is no limit, a slope of 0 that nothing depends on the temperature."""
    items = {free.key: free for free in held(LoadedRig(axis_logs.axis_rig(), axis_logs.axis_text(), "x"), CHANNELS)}
    assert set(items) == {"plant.sensors.axis.position.bias"}
    assert all(free.low <= 0.0 <= free.high and free.scale == 0.0 for free in items.values())


def test_the_tag_stands_among_others_and_in_any_place() -> None:
    text = "plant:\n  a: 1 m   # [A] guessed, [fixed] by hand\n  b: {c: 2, d: x}  # [DS]\n  e: 3  # see [1], [mm]\n"
    tree = parse(text, "x.yaml")
    assert [tag_of(tree, ("plant", *key)) for key in (("a",), ("b", "c"), ("e",), ("f",))] == ["fixed", "DS", "", "A"]


def test_check_lists_what_is_held_and_names_a_slip() -> None:
    loaded = load_rig("force_axis")
    text = fixed(loaded.text, "viscous_friction").replace("mass: 95.1089 kg                # [B]", "mass: 95.1089 kg  # [fixd]")
    found = check_rig(LoadedRig(rig_from_text(text), text, "axis.yaml"), datetime.date(2026, 1, 1))
    texts = {finding.level: finding.text for finding in found if "held fixed" in finding.text or "is no tag" in finding.text}
    assert "plant.effects[1].coefficient" in texts["ok"]
    assert "[fixd] is no tag" in texts["warning"]
    assert "nearest is 'fixed'" in texts["warning"]
    assert texts["warning"].startswith("axis.yaml:")


@pytest.mark.parametrize("name", ["ornl_testbed", "ornl_testbed_can", "force_axis", "seal_rig", "rotary_actuator", "cu_rigid_arm"])
def test_the_shipped_rigs_have_no_slip(name: str) -> None:
    assert not [f.text for f in check_rig(load_rig(name), datetime.date(2026, 1, 1)) if "is no tag" in f.text]
