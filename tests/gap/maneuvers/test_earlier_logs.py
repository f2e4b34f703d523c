"""What logs at hand say of an explanation's numbers, and what that does to the choice of the next maneuver: against dense algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from config.loading.load import LoadedRig, load_rig, rig_from_text
from gap.data.noise import noise_floors
from gap.data.windows import prepare
from gap.fitting.evaluation import Costing, costing, evaluate
from gap.fitting.fit import Fit, covariance, unfitted
from gap.fitting.model import Model
from gap.fitting.sensitivity import projected, sensitivities
from gap.maneuvers.closed_loop import measured_on
from gap.maneuvers.designs import ManeuverDesign
from gap.maneuvers.earlier_logs import EarlierLogs, earlier_logs
from gap.maneuvers.rivals import no_effect, rival_of
from gap.maneuvers.separation import Comparison, Rival
from tests.support.gap import axis_logs
from tests.support.gap.compared import compare

START = {"start": {"axis": "0.125 m"}, "joint": "axis"}
SLOW = ManeuverDesign("slow_triangle", {**START, "amplitude": "0.01 m", "rate": "0.02 m/s", "cycles": 1})
TRIANGLE = ManeuverDesign("slow_triangle", {**START, "amplitude": "0.04 m", "rate": "0.08 m/s", "cycles": 2})


def axis() -> LoadedRig:
    return LoadedRig(axis_logs.axis_rig("coulomb_friction"), axis_logs.axis_text("coulomb_friction"), "axis.yaml")


def fitted(model: Model, truth: Rival) -> tuple[Fit, Costing]:
    """The model as it stands beside a log of the truth."""
    log = measured_on(truth.model.fitted_rig(), SLOW.content)
    experiment = prepare(log, model.rig, noise_floors([log], model.rig), 0.25, ["axis.position"])
    now = evaluate(experiment, model, None)
    costs = costing([experiment], [now.left])
    return unfitted(model, [evaluate(experiment, model, costs)], costs), costs


@pytest.fixture(scope="module")
def known() -> tuple[Rival, Fit, Costing]:
    rival = rival_of(axis(), "asymmetric_friction", "axis", {"friction_difference": 4.0, "coefficient_difference": 20.0})
    return rival, *fitted(rival.model, rival)


def test_with_the_priors_it_is_the_inverse_of_the_fit_s_covariance(known: tuple[Rival, Fit, Costing]) -> None:
    rival, done, costs = known
    scales = rival.model.scales
    priors = np.diag([1.0 if free.prior else 0.0 for free in rival.model.free])
    spread = np.linalg.inv(earlier_logs(rival.model, done, costs).information + priors) * np.outer(scales, scales)
    np.testing.assert_allclose(np.sqrt(np.diag(spread)), np.sqrt(np.diag(covariance(done, costs))), rtol=0.02)


def test_an_effect_that_the_fitted_model_does_not_have_is_computed(known: tuple[Rival, Fit, Costing]) -> None:
    """The same information from the fit with the effect and from the one without it: the constants are felt alike."""
    rival, done, costs = known
    without, _ = fitted(no_effect(axis()).model, rival)
    with_it, from_less = earlier_logs(rival.model, done, costs), earlier_logs(rival.model, without, costs)
    size = max(1.0, without.cost) / max(1.0, done.cost)
    assert from_less.paths == with_it.paths
    assert size * from_less.information[-1, -1] == pytest.approx(with_it.information[-1, -1], rel=1e-6)


def test_numbers_are_known_by_their_place_in_the_rig_not_by_their_order(known: tuple[Rival, Fit, Costing]) -> None:
    rival, done, costs = known
    whole = earlier_logs(rival.model, done, costs)
    numbers = [len(rival.model.free) - 1, 2, 0]
    part = rival.model.restricted(numbers)
    part = part.with_theta(part.theta + np.array([3.0, 0.0, 0.0]) * part.scales)
    information, off = whole.of(part)
    np.testing.assert_array_equal(information, whole.information[np.ix_(numbers, numbers)])
    np.testing.assert_allclose(off, [3.0, 0.0, 0.0])


def test_a_number_never_fitted_is_free(known: tuple[Rival, Fit, Costing]) -> None:
    rival, _, costs = known
    only_constants = earlier_logs(no_effect(axis()).model, fitted(no_effect(axis()).model, rival)[0], costs)
    information, off = only_constants.of(rival.model)
    assert not information[-1].any()
    assert off[-1] == 0.0


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    loaded = axis()
    return compare(loaded, rival_of(loaded, "coulomb_friction", "axis", {"friction": 2.0}), no_effect(loaded), TRIANGLE.content)


def with_logs(comparison: Comparison, information: np.ndarray, off: float) -> Comparison:
    """The rival as if logs had given that information, `off` scales away from where its numbers stand."""
    model = comparison.rival.model
    logs = EarlierLogs(tuple(free.path for free in model.free), model.theta - off * model.scales, information)
    return replace(comparison, rival=replace(comparison.rival, earlier=logs))


@pytest.mark.parametrize("off", [0.0, 1.5])
def test_earlier_logs_are_fitted_beside_the_new_one(comparison: Comparison, off: float) -> None:
    """T is the least of ‖e − J φ‖² + ‖φ‖² + ‖L (φ + off)‖², L such that its square is the information: one long least-squares problem."""
    rival, seen = comparison.rival, comparison.seen
    count = len(rival.model.free)
    columns = projected(seen, sensitivities(rival.model, [seen.experiment], range(count), [seen.readings])[0])
    J, e = columns.reshape(count, -1).T, seen.left.ravel()
    L = np.random.default_rng(5).normal(size=(count, count)) * 20.0
    stacked = np.concatenate([J, np.eye(count), L])
    wanted = np.concatenate([e, np.zeros(count), -L @ np.full(count, off)])
    least = float(np.linalg.lstsq(stacked, wanted, rcond=None)[1][0])
    found = with_logs(comparison, L.T @ L, off).exact()
    assert pytest.approx(least - float(np.sum(comparison.run.own.left**2)), rel=1e-6) == found.T


def test_more_logs_never_separate_less(comparison: Comparison) -> None:
    count = len(comparison.rival.model.free)
    tells = [with_logs(comparison, size * np.eye(count), 0.0).exact().T for size in (0.0, 1.0, 1e2, 1e4, 1e8)]
    assert tells == sorted(tells)
    assert tells[0] == pytest.approx(comparison.exact().T)
    assert tells[-1] > 1.2 * tells[0]


def test_a_rigid_link_s_fit_says_nothing_of_one_that_bends() -> None:
    """It has fewer start states; every number is computed then, and none is left out."""
    shipped = load_rig("ornl_testbed")
    text = "".join(line for line in shipped.text.splitlines(keepends=True) if "effect: link_flexibility," not in line)
    rigid = LoadedRig(rig_from_text(text), text, shipped.path)
    whole = rival_of(rigid, "link_flexibility", "link").model
    bending = whole.restricted([0, *whole.of_effect(whole.added[-1])])
    numbers = range(len(bending.free))
    log = measured_on(rigid.rig, ManeuverDesign("jog").content)
    experiment = prepare(log, rigid.rig, noise_floors([log], rigid.rig), 0.1, ["rotary.position", "tip.deflection"])
    less = no_effect(rigid).model.restricted([0])
    now = evaluate(experiment, less, None)
    costs = costing([experiment], [now.left])
    done = unfitted(less, [evaluate(experiment, less, costs)], costs)
    found = earlier_logs(bending, done, costs)
    now = evaluate(experiment, bending, None)
    assert now.left.shape != done.evaluations[0].left.shape
    own = projected(now, sensitivities(bending, [experiment], numbers, [now.readings])[0]).reshape(len(numbers), -1)
    np.testing.assert_allclose(found.information * max(1.0, done.cost) * costs.tau, own @ own.T, rtol=1e-9)
