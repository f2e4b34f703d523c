"""A servo axis of other code than the product's: Newton's law with friction that yields in several places (Maxwell-slip, Iwan 1966).

m v' = gain u + offset − c v − Σ F_i,  F_i a spring that slips at its level. Symplectic Euler at a tenth of the log's period.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import njit

PERIOD_S, STEPS = 0.001, 10
MASS_KG, GAIN_N_PER_V, OFFSET_N, VISCOUS_NS_PER_M = 95.1089, 35.1507, -3.16, 203.5  # of config/rigs/force_axis.yaml
FRICTION_N = 20.39
BREAK_AWAY_M = (2e-5, 6e-5, 2e-4, 6e-4)
Columns = dict[str, np.ndarray]


def maxwell_axis(seed: int, duration_s: float, noise_m: float = 2e-6, break_away_m: Sequence[float] = BREAK_AWAY_M) -> Columns:
    """A log as tests.support.gap.axis_logs writes it; back and forth with a seed's frequencies, with rests and slow reversals."""
    t = PERIOD_S * np.arange(round(duration_s / PERIOD_S))
    draw = np.random.default_rng(seed)
    waves = (draw.uniform(0.6, 1.2) * np.sin(2 * np.pi * f * (t + draw.uniform(0, 3))) for f in draw.uniform(0.5, 2.2, 3))
    command = 0.09 + sum(waves)
    levels = np.full(len(break_away_m), FRICTION_N / len(break_away_m))
    position = _moved(command, levels, levels / np.array(break_away_m))
    read = 1e-6 * np.rint((position + noise_m * draw.standard_normal(len(t))) / 1e-6)
    return {"t_s": t, "axis.position": read, "axis.command_V": command}


@njit(cache=True)  # type: ignore[untyped-decorator]
def _moved(command: np.ndarray, levels: np.ndarray, springs: np.ndarray) -> np.ndarray:
    step = PERIOD_S / STEPS
    x, v = 0.12, 0.0
    held = np.zeros(len(levels))
    out = np.empty(len(command))
    for row in range(len(command)):
        out[row] = x
        for _ in range(STEPS):
            force = GAIN_N_PER_V * command[row] + OFFSET_N - VISCOUS_NS_PER_M * v
            for i in range(len(levels)):
                held[i] = min(max(held[i] + springs[i] * v * step, -levels[i]), levels[i])
                force -= held[i]
            v += step * force / MASS_KG
            x += step * v
    return out
