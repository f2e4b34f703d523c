"""The fit's own coordinates: there and back, their ends and their slopes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.loading.load import load_rig
from gap.evidence.score.coordinates import ends, magnitudes, of_other_priors, one_way, phi_of, stretch, theta_of
from gap.fitting.model import Free, Model

STIFF = Free(("joints", "axis", "bristle_stiffness"), "plant.joints.axis.bristle_stiffness", "N/m", 1e6, 1e7, 1e5, 4.1e7, True)
MASS = Free(("joints", "axis", "mass"), "plant.joints.axis.mass", "kg", 95.0, 1.9, 87.0, 103.0, True)
SIZE = Free(("effects", 0, "friction"), "friction", "N", 0.0, 5.0, 0.0, 100.0, False)


def model(*theta: float) -> Model:
    return Model(load_rig("force_axis").rig, (STIFF, MASS, SIZE), np.array(theta))


@given(st.floats(1e5, 4.1e7), st.floats(87.0, 103.0), st.floats(0.0, 100.0))
def test_there_and_back(stiffness: float, mass: float, size: float) -> None:
    one = model(stiffness, mass, size)
    np.testing.assert_allclose(theta_of(one, phi_of(one)), one.theta, rtol=1e-12, atol=1e-9)


def test_what_the_rig_file_says_is_the_middle() -> None:
    assert phi_of(model(1e6, 95.0, 0.0)) == pytest.approx([0.0, 0.0, 0.0])


def test_only_a_constant_that_may_be_several_times_its_value_is_known_by_its_magnitude() -> None:
    """A tenth is as far as ten times; one standard deviation up is start + scale, as for the others."""
    assert magnitudes(model(1e6, 95.0, 0.0)) == [0]
    assert phi_of(model(1e5, 95.0, 0.0))[0] == pytest.approx(-phi_of(model(1e7, 95.0, 0.0))[0])
    assert phi_of(model(1.1e7, 96.9, 5.0)) == pytest.approx([1.0, 1.0, 1.0])


def test_ends_are_those_of_the_values() -> None:
    low, high = ends(model(1e6, 95.0, 0.0))
    np.testing.assert_allclose(theta_of(model(1e6, 95.0, 0.0), low), [1e5, 87.0, 0.0])
    np.testing.assert_allclose(theta_of(model(1e6, 95.0, 0.0), high), [4.1e7, 103.0, 100.0])


def test_stretch_is_the_slope_of_the_values() -> None:
    one, move = model(3e6, 96.0, 7.0), 1e-5
    slope = (theta_of(one, phi_of(one) + move) - theta_of(one, phi_of(one) - move)) / (2 * move)
    np.testing.assert_allclose(stretch(one) * one.scales, slope, rtol=1e-6)


def test_a_wide_prior_changes_coordinates_and_not_what_readings_do() -> None:
    """Readings that are the values: d θ / dφ in either, by differences; the number that the other model lacks stays as it is."""
    one, move = model(3e6, 96.0, 7.0), 1e-6
    wide = Model(one.rig, (replace(STIFF, prior=False), MASS), one.theta[:2])

    def slopes(of: Model) -> np.ndarray:
        phi, columns = phi_of(of), []
        for k in range(len(phi)):
            step = np.eye(len(phi))[k] * move
            columns.append((theta_of(of, phi + step) - theta_of(of, phi - step))[k] / (2 * move))
        return np.array(columns)[:, None, None, None]

    found = of_other_priors(slopes(one), one, wide)
    np.testing.assert_allclose(found[:2], slopes(wide), rtol=1e-6)
    np.testing.assert_allclose(found[2], slopes(one)[2], rtol=1e-6)


@pytest.mark.parametrize("stiffness", [1.1e5, 3e5, 1e6, 7e6, 4e7])
@pytest.mark.parametrize("reach", [0.3, 3.0])
def test_sensitivities_are_taken_within_the_range(monkeypatch: pytest.MonkeyPatch, stiffness: float, reach: float) -> None:
    """Of a contact that may be a tenth to forty times as stiff, wherever it stands: readings that are the values, by secants."""
    one, tried = model(stiffness, 95.0, 0.0), list[np.ndarray]()

    def values(experiments: list[object], vectors: list[np.ndarray]) -> list[list[np.ndarray]]:
        tried.extend(vectors)
        return [[v[:, None, None] for v in vectors] for _ in experiments]

    monkeypatch.setattr(Model, "vector", lambda self, theta: theta)
    monkeypatch.setattr("gap.evidence.score.coordinates.on_logs", values)
    (found,) = one_way(one, [None], range(3), [one.theta[:, None, None]], np.full(3, reach))  # type: ignore[list-item]
    low, high = np.array([[f.low, f.high] for f in one.free]).T
    for k, moved in enumerate(tried):
        assert np.all((low * (1 - 1e-12) <= moved) & (moved <= high * (1 + 1e-12)))
        step = phi_of(one.with_theta(moved))[k] - phi_of(one)[k]
        assert 0.0 < abs(step) <= reach * (1 + 1e-12)
        assert found[k, k, 0, 0] == pytest.approx((moved[k] - one.theta[k]) / step)
