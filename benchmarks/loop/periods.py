"""What the begins of a loop's cycles say of its timing, for every program the same way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

FIGURES = ("p50", "p99", "p99.9", "missed")


def figures(began_us: Sequence[float], period_us: float) -> dict[str, float]:
    """Quantiles of how far each period was from `period_us`, in us; `missed`: periods in which no cycle began."""
    periods = np.diff(np.asarray(began_us))
    found = dict(zip(FIGURES[:3], np.quantile(np.abs(periods - period_us), (0.5, 0.99, 0.999)).tolist(), strict=True))
    return found | {"missed": float(np.sum(np.maximum(0, np.floor(periods / period_us) - 1))), "cycles": len(began_us)}


def began_of_lateness(late_us: Sequence[float], period_us: float) -> list[float]:
    """For a program that tells how late each cycle began and skips the deadlines that passed meanwhile."""
    began, deadline = [], 0.0
    for late in late_us:
        began.append(deadline + late)
        deadline += period_us * (1 + late // period_us)
    return began
