"""A channel at the end of its sensor's range is left out where it is cut off, and nowhere else."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.data.measured import MeasuredChannel
from gap.data.windows import Experiment
from gap.evidence.noise.uncut import uncut
from sim_backend.kernel.batch import WindowPlan

NAMES = ["rotary.position", "rotary.return_pressure"]


def log_of(noise: np.ndarray, level_Pa: float) -> Any:
    """Two channels at 1 kHz; the pressure as a sensor gives it that ends at 0."""
    pressure = np.maximum(level_Pa + noise, 0.0)
    values = {NAMES[0]: 0.1 + 0.0 * noise, NAMES[1]: pressure}
    return SimpleNamespace(channels={k: MeasuredChannel(k, "", v, v) for k, v in values.items()}, rows=len(noise))


@pytest.mark.parametrize(("level_Pa", "left"), [(0.0, 0), (1e6, 4)])
def test_windows_that_touch_the_end_of_the_range(level_Pa: float, left: int) -> None:
    log = log_of(5e4 * np.random.default_rng(1).standard_normal(400), level_Pa)
    plan = WindowPlan(np.zeros((400, 2)), np.arange(0, 400, 100), 100, 3, 0.001, np.zeros((400, 8)))
    measured = np.stack([np.stack([log.channels[n].values[s : s + 100 : 3] for n in NAMES], axis=1) for s in plan.starts])
    made = Experiment(log, plan, np.zeros(1), (0, 1), measured, np.ones(2), {}, 0.0)
    found = uncut(made, load_rig("ornl_testbed").rig, NAMES).measured
    assert np.isfinite(found[:, :, 1]).all(axis=1).sum() == left
    assert not np.isfinite(found[:, :, 1]).any() or left
    np.testing.assert_array_equal(found[:, :, 0], measured[:, :, 0])
