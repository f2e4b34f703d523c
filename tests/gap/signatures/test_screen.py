"""What a signature would take from residual and strain, against the least-squares problem solved anew with and without it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gap.fitting.evaluation import Costing
from gap.signatures.projection import ConstantsProjection
from gap.signatures.screen import Screening, TriedSize

WINDOWS, VALUES, CONSTANTS, TAU = 4, 30, 5, 2.5


def fitted(draw: np.random.Generator) -> tuple[Any, NDArray[np.float64], NDArray[np.float64]]:
    """A fit at its optimum: constants pulled from their priors just as far as the residual pulls them. Also its columns and residual."""
    columns = draw.normal(size=(CONSTANTS, WINDOWS * VALUES))
    measured = 0.5 * draw.normal(size=WINDOWS * VALUES) + columns.T @ draw.normal(size=CONSTANTS)
    pulls = np.linalg.solve(columns @ columns.T + TAU * np.eye(CONSTANTS), columns @ measured)
    left = measured - columns.T @ pulls
    experiment = SimpleNamespace(measured=np.zeros((WINDOWS, VALUES, 1)))
    evaluation = SimpleNamespace(experiment=experiment, left=left.reshape(WINDOWS, VALUES))
    model = SimpleNamespace(free=[SimpleNamespace(prior=True)] * CONSTANTS, pulls=pulls)
    shaped = columns.reshape(CONSTANTS, WINDOWS, VALUES)
    return SimpleNamespace(evaluations=(evaluation,), columns=(shaped,), model=model, cost=0.25), columns, measured


def least(rows: NDArray[np.float64], priors: NDArray[np.float64], measured: NDArray[np.float64]) -> float:
    """Σ residual² + τ Σ priors θ², at its smallest."""
    stacked = np.vstack([rows.T, np.diag(np.sqrt(TAU * priors))])
    right = np.concatenate([measured, np.zeros(len(priors))])
    return float(np.sum((right - stacked @ np.linalg.lstsq(stacked, right, rcond=None)[0]) ** 2))


@pytest.mark.parametrize("seed", range(5))
def test_slope_and_curvature_are_those_of_the_whole_problem(seed: int) -> None:
    draw = np.random.default_rng(seed)
    fit, columns, measured = fitted(draw)
    row = draw.normal(size=(1, WINDOWS * VALUES)) + columns[:1]
    projection = ConstantsProjection(fit, Costing(np.array([1e9]), TAU))
    left = projection.project_out(row)
    slope, curvature = float(projection.slopes(row, left)[0]), float(np.sum(row * left))
    without = least(columns, np.ones(CONSTANTS), measured)
    with_it = least(np.vstack([columns, row]), np.append(np.ones(CONSTANTS), 0.0), measured)
    assert slope**2 / curvature == pytest.approx(without - with_it, rel=1e-6)
    assert projection.energy == pytest.approx(without, rel=1e-9)


def test_an_effect_that_would_have_to_be_less_than_nothing_explains_nothing() -> None:
    model: Any = None
    point = TriedSize(model, np.ones(3), slope=-2.0, curvature=4.0, most=10.0, least=0.0, answers=np.zeros(1))
    assert point.multiple == 0.0
    assert point.lowers(point.multiple) == 0.0
    either = TriedSize(model, np.ones(3), slope=-2.0, curvature=4.0, most=10.0, least=-10.0, answers=np.zeros(1))
    assert either.multiple == -0.5
    assert either.lowers(either.multiple) == pytest.approx(1.0)


@pytest.mark.parametrize(("cosine", "alike"), [(0.99, ["delay"]), (-0.99, ["delay"]), (0.5, [])])
def test_one_direction_is_one_line_whatever_its_sign(cosine: float, alike: list[str]) -> None:
    """A lag and a delay nearly, or not at all, in one direction."""
    names, cosines = ("lag", "delay", "gravity"), np.eye(3)
    cosines[0, 1] = cosines[1, 0] = cosine
    signatures: Any = tuple(SimpleNamespace(candidate=SimpleNamespace(effect=name, where="axis")) for name in names)
    assert [candidate.effect for candidate in Screening(signatures, cosines).same_direction("lag", "axis")] == alike
