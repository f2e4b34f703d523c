"""Windows reached from kept states are simulated as if the whole log had been, whatever the parameters that kept them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.data.windows import Experiment
from gap.fitting.model import Model
from gap.fitting.simulate import kept, on_logs, remembering, simulate, some, warmed
from sim_backend.kernel.batch import carry
from sim_backend.memory.layout import J_START, J_STRIDE, H, J, Vector
from tests.support.gap import testbed_logs

RIG = load_rig("ornl_testbed").rig
CHOSEN = np.array([2, 3, 4, 11, 12, 13, 20, 21, 22, 29, 30, 31])


@pytest.fixture(scope="module")
def whole() -> Experiment:
    """Both joints for 15 s, with commands that stand still now and then, so that a hysteresis remembers."""
    t = 0.001 * np.arange(15_000)
    still = (t % 3.0) > 2.0
    command = np.column_stack([0.4 * np.sin(2 * np.pi * 0.9 * t), 0.6 * np.sin(2 * np.pi * 0.7 * t)])
    command[still] = command[np.maximum.accumulate(np.where(still, 0, np.arange(len(t))))][still]
    return testbed_logs.experiment(RIG, command, 3, RIG, workers=2)


def vector(**changes: float) -> Vector:
    p = Model(RIG, (), np.empty(0)).vector()
    for name, value in changes.items():
        for slot in range(2):
            p[J_START + slot * J_STRIDE + J[name]] = value
    return p


@pytest.mark.parametrize("changes", [{}, {"HYSTERESIS": 0.01}, {"HYSTERESIS": 0.01, "DELAY": 3.3e-3}, {"HYSTERESIS": 0.0}])
def test_hysteresis_is_that_of_the_parameters(whole: Experiment, changes: dict[str, float]) -> None:
    few = remembering(some(whole, CHOSEN), vector())
    p = vector(**changes)
    _, entered = kept(few, p)
    _, through = kept(whole, p)
    play = slice(H.PLAY, H.PLAY + 2)
    np.testing.assert_allclose(entered[:, play], through[CHOSEN][:, play], atol=2e-6)
    before, after = (readings[CHOSEN] / whole.sigma for readings in simulate(whole, [vector(), p]))
    off = simulate(few, [p])[0] / whole.sigma - after
    assert np.sqrt(np.mean(off**2)) < max(0.05 * np.sqrt(np.mean((after - before) ** 2)), 0.02), "the lead-in makes up for the rest"


def test_a_batch_on_two_threads_has_every_bit_of_single_calls(whole: Experiment) -> None:
    vectors = [vector(), vector(HYSTERESIS=0.01), vector(DELAY=3.3e-3)]
    one, two = (simulate(replace(whole, workers=threads), vectors) for threads in (1, 2))
    for p, alone, beside in zip(vectors, one, two, strict=True):
        single, _ = carry(whole.start, warmed(whole, p), whole.plan)
        assert np.array_equal(single[:, :, whole.columns], alone)
        assert np.array_equal(alone, beside)


@pytest.mark.parametrize("number", [1, 3])
def test_logs_beside_each_other_have_every_bit_of_each_by_itself(whole: Experiment, number: int) -> None:
    """Also where idle threads would have cut one of them into parts."""
    vectors = [vector(), vector(HYSTERESIS=0.01), vector(DELAY=3.3e-3)][:number]
    logs = [whole, remembering(some(whole, CHOSEN), vector())]
    for log, beside in zip(logs, on_logs(logs, vectors), strict=True):
        for p, readings in zip(vectors, beside, strict=True):
            assert np.array_equal(simulate(log, [p])[0], readings)
