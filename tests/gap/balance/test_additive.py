"""The smooth description of a rest, against functions it was made from; the discrepancy, against a friction that was taken away."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gap.balance.additive import additive
from gap.balance.discrepancy import discrepancy
from gap.data.measured import load
from gap.remainder.remainder import sentence
from tests.support.gap import axis_logs

ROWS = 3000
BLOCKS = np.arange(ROWS) // 30


def test_two_inputs_are_found_in_order_with_their_curves() -> None:
    draw = np.random.default_rng(1)
    x, z, other = draw.uniform(-2, 2, ROWS), draw.uniform(0, 1, ROWS), draw.normal(size=ROWS)
    y = 3.0 * np.sin(x) + z**2 + 0.2 * draw.normal(size=ROWS)
    first, second = additive(y, {"other": other, "z": z, "x": x}, BLOCKS)
    assert (first.name, second.name) == ("x", "z")
    np.testing.assert_allclose(first.value - first.value.mean(), 3.0 * np.sin(first.at) - np.mean(3.0 * np.sin(first.at)), atol=0.1)
    part = np.var(3.0 * np.sin(x))
    assert first.share == pytest.approx(part / np.var(y), abs=0.02)
    assert second.share == pytest.approx(np.var(z**2) / (np.var(z**2) + 0.2**2), abs=0.05)


def test_noise_is_carried_by_nothing() -> None:
    """Fitted to all rows, eight splines of eleven weights would explain some per cent each of two hundred."""
    draw = np.random.default_rng(2)
    inputs = {str(k): draw.normal(size=200) for k in range(8)}
    assert additive(draw.normal(size=200), inputs, np.arange(200) // 10) == []


def test_a_sign_has_two_levels_and_no_spline() -> None:
    draw = np.random.default_rng(3)
    sign = np.sign(draw.normal(size=ROWS))
    (found,) = additive(5.0 * sign + draw.normal(size=ROWS), {"sign": sign}, BLOCKS)
    np.testing.assert_array_equal(found.at, [-1.0, 1.0])
    assert found.value[1] - found.value[0] == pytest.approx(10.0, abs=0.1)


def test_friction_that_the_model_lacks_is_the_discrepancy_of_its_force_balance(tmp_path: Path) -> None:
    truth, model = axis_logs.axis_rig(), axis_logs.axis_rig("coulomb_friction")
    logs = [load(axis_logs.write(tmp_path / f"{seed}.csv", axis_logs.simulated(truth, seed, 8.0)), model) for seed in (1, 2)]
    found = discrepancy(logs, model)
    assert found is not None
    assert (found["equation"], found["unit"]) == ("force balance of axis", "N")
    carried = found["carried_by"][0]
    assert carried["input"] in ("sign of axis.velocity", "axis.velocity")
    assert carried["share"] > 0.7
    assert max(np.abs(carried["value"])) == pytest.approx(20.39, rel=0.15)  # the friction
    assert carried["value"][-1] > 0.0  # what the drive gives and the model has no use for
    rest = {"excess": 3.0, "channel": "axis.position", "share": 1.0, "carried_by": [], "discrepancy": found}
    assert "The force balance of axis comes out uneven" in sentence(rest)
    assert discrepancy(logs, truth) is None
