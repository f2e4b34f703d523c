"""A spool that reaches the end of its bore stops dead, and leaves at once when it is called back ((P3)): by scipy, with an event there."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from config.loading.load import load_rig, rig_from_text
from sim_backend.memory.layout import D_STRIDE, D
from sim_backend.plant import SimulatedRig

PERIOD_S = 1e-3
LINEAR = 1  # slot of a joint that slides
TIME_CONSTANT_S = 2.5e-3
VALVE = "{{effect: valve_lag, where: axis, time_constant: {time} s, damping_ratio: {damping}}}"


def spool_of(volts: np.ndarray, damping: float) -> np.ndarray:
    """Opening at the end of every period."""
    entry = VALVE.format(time=TIME_CONSTANT_S, damping=damping)
    lines = [line for line in load_rig("force_axis").text.splitlines() if "valve_null_bias" not in line]
    text = "\n".join(lines).replace("  effects:\n", f"  effects:\n    - {entry}\n")
    sim = SimulatedRig(rig_from_text(text))
    found = np.empty(len(volts))
    for k, volt in enumerate(volts):
        sim.advance([float(volt)], PERIOD_S)
        found[k] = sim.state[LINEAR * D_STRIDE + D.SPOOL]
    return found


def by_scipy(wanted: np.ndarray, damping: float) -> np.ndarray:
    """The same, each period by itself; where the spool meets an end its rate is 0 from there on."""
    w, now, found = 1.0 / TIME_CONSTANT_S, np.zeros(2), np.empty(len(wanted))

    def end(t: float, y: np.ndarray, *_: float) -> float:
        return abs(y[0]) - 1.0

    end.terminal, end.direction = True, 1.0  # type: ignore[attr-defined]
    for k, want in enumerate(wanted):
        left = PERIOD_S
        while left > 0.0:
            if abs(now[0]) >= 1.0 and want * np.sign(now[0]) >= 1.0:
                break  # held there
            done = solve_ivp(lambda t, y, want=want: (y[1], w * w * (want - y[0]) - 2.0 * damping * w * y[1]), (0.0, left), now,
                             events=end, rtol=1e-9, atol=1e-12, max_step=1e-4)  # fmt: skip
            now, left = done.y[:, -1], left - done.t[-1]
            if done.status == 1:
                now = np.array([np.sign(now[0]), 0.0])
        found[k] = now[0]
    return found


@pytest.mark.parametrize("damping", [0.3, 0.8, 1.5])
@pytest.mark.parametrize("end", [1.0, -1.0])
def test_it_leaves_the_end_of_its_bore_when_it_is_called_back(damping: float, end: float) -> None:
    wanted = end * np.concatenate([np.full(40, 1.0), np.full(20, 0.4), np.full(20, -1.0), np.full(30, 0.0)])
    found, expected = spool_of(10.0 * wanted, damping), by_scipy(wanted, damping)
    np.testing.assert_allclose(found, expected, atol=0.01)
    assert np.abs(found).max() <= 1.0 + 1e-9


def test_a_valve_driven_from_end_to_end_is_never_left_behind() -> None:
    """Noise of twice the valve's full scale, cut off: half of the time at an end."""
    volts = np.clip(np.random.default_rng(1).normal(0.0, 20.0, 300), -10.0, 10.0)
    np.testing.assert_allclose(spool_of(volts, 0.5), by_scipy(volts / 10.0, 0.5), atol=0.02)
