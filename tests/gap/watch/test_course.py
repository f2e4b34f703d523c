"""Steps and drifts in series of logs: found where they are, rarely where they are not."""

from __future__ import annotations

import numpy as np
import pytest

from gap.watch.course import course

DAYS = 2.0 * np.arange(24)


def noisy(seed: int, truth: np.ndarray, between: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    draw = np.random.default_rng(seed)
    sds = draw.uniform(0.5, 1.5, len(truth))
    return truth + np.hypot(sds, between) * draw.standard_normal(len(truth)), sds


def test_a_step_is_found_at_its_log() -> None:
    truth = np.where(np.arange(24) >= 15, 20.0, 10.0)
    for seed in range(20):
        found = course(DAYS, *noisy(seed, truth))
        assert found.steps == (15,)
        assert not found.drifts
        height, width = found.step(0)
        assert abs(height - 10.0) < 2 * width
        assert found.now[0] == pytest.approx(20.0, abs=1.5)


def test_a_drift_is_no_flight_of_steps() -> None:
    for seed in range(20):
        found = course(DAYS, *noisy(seed, 10.0 + 0.3 * DAYS))
        assert found.drifts
        assert found.steps == ()
        slope, width = found.slope
        assert abs(slope - 0.3) < 2 * width


def test_wear_that_a_repair_takes_back_is_a_drift_with_a_step() -> None:
    truth = 10.0 + 0.4 * DAYS - np.where(np.arange(24) >= 12, 9.6, 0.0)
    found = [course(DAYS, *noisy(seed, truth)) for seed in range(20)]
    assert sum(each.drifts and each.steps == (12,) for each in found) >= 18


def test_after_a_repair_the_last_piece_speaks_for_itself() -> None:
    """Wear up to the repair says nothing of the weeks since."""
    truth = np.where(np.arange(24) < 14, 10.0 + 0.6 * DAYS, 10.0)
    found = [course(DAYS, *noisy(seed, truth)) for seed in range(20)]
    assert all(each.steps == (14,) and not each.drifts for each in found)
    assert sum(abs(each.now[0] - 10.0) < each.fit.times_sd() * each.now[1] for each in found) >= 18
    assert sum(abs(each.slope[0]) < each.slope[1] for each in found) >= 18


@pytest.mark.parametrize("between", [0.0, 1.0, 5.0])
@pytest.mark.parametrize("logs", [4, 8, 24])
def test_where_nothing_happens_nothing_is_told(logs: int, between: float) -> None:
    """A step and a drift are asked for, each with a chance of at most 1 %."""
    told = 0
    for seed in range(60):
        found = course(DAYS[:logs], *noisy(seed, np.full(logs, 10.0), between))
        told += bool(found.steps) or found.drifts
    assert told <= 5, "expected: at most 1.2"


def test_one_log_apart_is_scatter() -> None:
    truth = np.full(24, 10.0)
    truth[11] = 40.0
    assert course(DAYS, *noisy(3, truth)).steps == ()


def test_logs_of_one_moment_have_no_step_between_them() -> None:
    days = np.repeat([0.0, 10.0], 4)
    values = np.array([1.0, 1.0, 9.0, 9.0, 9.0, 9.0, 1.0, 1.0])
    assert set(course(days, values, np.full(8, 0.1)).steps) <= {4}
