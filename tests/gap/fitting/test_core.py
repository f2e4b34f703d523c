"""The parts of the search against closed forms and independent means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.parsing.provenance import tag_of
from config.parsing.yaml_tree import parse
from config.schema.effect_library import EFFECTS
from daemon.cli.main import main
from gap.data.measured import load
from gap.data.noise import correlation_time, local_variances
from gap.data.windows import prepare
from gap.fitting.evaluation import evaluate, mean_cost
from gap.fitting.initial_states import Projection, marginalised_readings
from gap.fitting.model import Free, Model, with_values
from gap.fitting.nuisance import PRIOR_SD, nuisances
from gap.fitting.simulate import residual, simulate
from gap.outcome.model_file import with_effect_line
from gap.suspects.candidates import candidates
from sim_backend.memory.layout import Target
from tests.support.gap import axis_logs

CHANNELS = ["axis.position"]


def test_local_variance_of_white_noise_on_a_curve() -> None:
    t = np.linspace(0, 1, 4200)
    noise = np.random.default_rng(1).normal(0, 0.01, t.size)
    assert np.mean(local_variances(np.sin(4 * t) + noise)) == pytest.approx(1e-4, rel=0.08)


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.8])
def test_correlation_time_of_first_order_noise(phi: float) -> None:
    rng = np.random.default_rng(2)
    x = np.zeros((200, 500))
    for k in range(1, 500):
        x[:, k] = phi * x[:, k - 1] + rng.normal(size=200)
    assert correlation_time(x[:, 50:]) == pytest.approx((1 + phi) / (1 - phi), rel=0.15)


def test_marginalising_is_the_gaussian_integral() -> None:
    """Cost of the projected residual = eᵀ (I + A Aᵀ)⁻¹ e, by dense inversion."""
    rng = np.random.default_rng(3)
    a, e = rng.normal(size=(2, 30, 4)), rng.normal(size=(2, 30))
    gain = np.linalg.solve(np.einsum("wnk,wnl->wkl", a, a) + np.eye(4), a.transpose(0, 2, 1))
    left = Projection(a, gain).apply(e)
    for w in range(2):
        direct = e[w] @ np.linalg.inv(np.eye(30) + a[w] @ a[w].T) @ e[w]
        assert left[w] @ left[w] == pytest.approx(direct, rel=1e-9)


def test_the_true_model_stands_at_the_noise_floor(tmp_path: Path) -> None:
    rig = axis_logs.axis_rig()
    log = load(axis_logs.write(tmp_path / "a.csv", axis_logs.simulated(rig, 4)), rig)
    sigma = {"axis.position": np.hypot(2e-6, 1e-6 / np.sqrt(12))}
    experiment = prepare(log, rig, sigma, 0.2, CHANNELS)
    cost = mean_cost([evaluate(experiment, Model(rig, (), np.empty(0)), None)])
    assert cost == pytest.approx(1.0, abs=0.12)


def test_start_states_absorb_a_wrong_start(tmp_path: Path) -> None:
    """A window that starts with a wrong velocity costs little after marginalisation, much before."""
    rig = axis_logs.axis_rig()
    log = load(axis_logs.write(tmp_path / "a.csv", axis_logs.simulated(rig, 5)), rig)
    experiment = prepare(log, rig, {"axis.position": 2e-6}, 0.2, CHANNELS)
    experiment.plan.targets[:, Target.VELOCITY + 1] += 2e-3
    p = Model(rig, (), np.empty(0)).vector()
    e = residual(experiment, simulate(experiment, [p])[0])
    left = marginalised_readings(experiment, p)[1].apply(e)
    assert np.mean(left**2) < 0.01 * np.mean(e**2)


def test_prior_follows_the_tag() -> None:
    loaded = load_rig("ornl_testbed")
    found = {free.key: free for free in nuisances(loaded, frozenset(["rotary.position"]))}
    displacement = found["plant.joints.rotary.displacement"]
    assert displacement.tag == "D"
    assert displacement.scale == pytest.approx(PRIOR_SD["D"] * displacement.start)
    assert found["plant.supply.pressure"].tag == "P"
    assert found["plant.oil.initial_temperature"].scale == 2.0  # K; a share of a Celsius temperature means nothing
    assert not any("travel" in key or "sensors" in key for key in found)
    assert tag_of(parse(loaded.text, "r"), ("plant", "link", "payload")) == "P"


def test_every_effect_with_physics_is_searched() -> None:
    assert {name for name, effect in EFFECTS.items() if effect.search is None} == {"unnamed_remainder"}  # never searched, never found


def test_a_remainder_without_a_name_is_no_candidate_and_no_constant() -> None:
    text = axis_logs.axis_text() + "    - {effect: unnamed_remainder, where: axis, position: [0 m, 0.2 m], force: [3 N, -3 N]}\n"
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    assert not [c for c in candidates(axis_logs.axis_rig(), frozenset(CHANNELS)) if c.effect == "unnamed_remainder"]
    assert not [free for free in nuisances(loaded, frozenset(CHANNELS)) if free.path[:2] == ("effects", 3)]


def test_neutral_candidates_change_nothing(tmp_path: Path) -> None:
    rig = axis_logs.axis_rig()
    log = load(axis_logs.write(tmp_path / "a.csv", axis_logs.simulated(rig, 6, 3.0)), rig)
    experiment = prepare(log, rig, {"axis.position": 2e-6}, 0.2, CHANNELS)
    base = Model(rig, (), np.empty(0))
    plain = simulate(experiment, [base.vector()])[0]
    asked = [each for each in candidates(rig, frozenset(CHANNELS)) if each.effect != "sensor_polarity"]
    assert len(asked) > 10
    for candidate in asked:
        neutral = base.with_effect(candidate.entry, candidate.free)
        assert np.array_equal(simulate(experiment, [neutral.vector()])[0], plain), candidate.label


def test_with_values_reaches_every_depth() -> None:
    plant = axis_logs.axis_rig().plant
    assert plant is not None
    changed = with_values(plant, {("joints", "axis", "mass_kg"): 7.0, ("effects", 1, "coefficient"): 9.0})
    assert changed.joints["axis"].mass_kg == 7.0
    assert changed.effects[1].coefficient == 9.0
    assert plant.joints["axis"].mass_kg != 7.0


@pytest.mark.parametrize("name", ["force_axis", "ornl_testbed"])
def test_an_added_effect_is_one_new_line(name: str) -> None:
    loaded = load_rig(name)
    joint = next(iter(loaded.rig.joints))
    text = with_effect_line(loaded.text, f"- {{effect: transport_delay, where: {joint}, delay: 3 ms}}  # [gap] test")
    changed = rig_from_text(text)
    assert changed.plant is not None
    assert changed.plant.effects[-1].effect == "transport_delay"
    old, new = loaded.text.splitlines(), text.splitlines()
    assert [line for line in new if line not in old] == [new[next(k for k, line in enumerate(new) if "[gap]" in line)]]
    assert len(new) == len(old) + 1


def test_a_model_grows_and_shrinks() -> None:
    rig = axis_logs.axis_rig("coulomb_friction")
    loaded = LoadedRig(rig, axis_logs.axis_text("coulomb_friction"), "axis.yaml")
    free = nuisances(loaded, frozenset(CHANNELS))
    model = Model(rig, free, np.array([item.start for item in free]))
    chosen = next(c for c in candidates(rig, frozenset(CHANNELS)) if c.effect == "coulomb_friction")
    grown = model.with_effect(chosen.entry, chosen.free)
    assert len(grown.of_effect(grown.added[-1])) == 1
    assert grown.without_effect(grown.added[-1]).free == model.free


def test_a_bore_of_a_data_sheet_moves_no_further_than_four_times_what_is_granted(tmp_path: Path) -> None:
    """3 % for [DS], which `new-rig` writes beside it; held altogether by [fixed]."""
    flags = ["--bore", "16 mm", "--rod", "10 mm", "--stroke", "200 mm", "--mass", "5 kg", "--rated-flow", "10 l/min", "--supply", "70 bar"]
    assert (
        main(["new-rig", "bench", "--kind", "cylinder", *flags, "--resolution", "5 um", "--noise", "5 um", "-o", str(tmp_path / "b")]) == 0
    )
    text = load_rig(tmp_path / "b" / "bench.yaml").text
    bore = "plant.joints.axis.bore"

    def frees(content: str) -> dict[str, Free]:
        return {free.key: free for free in nuisances(LoadedRig(rig_from_text(content), content, "b"), frozenset({"axis.position"}))}

    found = frees(text)[bore]
    assert (found.tag, found.scale) == ("DS", pytest.approx(0.03 * 0.016))
    assert (found.low, found.high) == (pytest.approx(0.88 * 0.016), pytest.approx(1.12 * 0.016))
    assert bore not in frees(text.replace("bore: 16 mm  # [DS]", "bore: 16 mm  # [DS] [fixed]"))
