"""What an imbalance depends on: its mean in bins of velocity, command, position, pressure, time …, with block-bootstrap intervals."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from config.schema.rig import Rig
from gap.balance.balances import Balance
from gap.data.measured import Array, Measured
from gap.data.uniform_grid import bridged

BINS = 6
BOOTSTRAPS = 200
_BLOCK = 10  # neighbouring supports drawn together
_LEAST = 8  # supports a bin
_SHOWN = 3
CLEAR_CONTRAST = 4.0  # standard errors between the extreme bins of a dependence worth telling


@dataclass(frozen=True, slots=True)
class Dependence:
    """Mean imbalance in each bin of one operating variable. `contrast`: largest difference between bins in standard errors."""

    variable: str
    unit: str
    edges: Array
    means: Array
    half_width: Array  # 95 %
    contrast: float

    def as_dict(self) -> dict[str, Any]:
        return {
            "variable": self.variable,
            "unit": self.unit,
            "edges": [short(v) for v in self.edges],
            "imbalance": [short(v) for v in self.means],
            "ci95": [[short(m - h), short(m + h)] for m, h in zip(self.means, self.half_width, strict=True)],
        }

    def text(self) -> str:
        """`imbalance -19.8 N at axis.velocity -0.12 to -0.03, 21 N at 0.02 to 0.12`."""
        low, high = int(np.argmin(self.means)), int(np.argmax(self.means))
        spans = [f"{self.means[k]:.3g} {self.unit} at {self.edges[k]:.3g} to {self.edges[k + 1]:.3g}" for k in (low, high)]
        return f"by {self.variable}: {spans[0]}, {spans[1]}"


def dependences(balance: Balance, log: Measured, rig: Rig, seed: int = 0) -> list[Dependence]:
    """The strongest dependences, at most three, clearest first; empty when nothing stands out."""
    found = [
        d for name, values in operating_variables(log, rig).items() if (d := _binned(balance, name, values[balance.rows], seed)) is not None
    ]
    clear = sorted((d for d in found if d.contrast > CLEAR_CONTRAST), key=lambda d: -d.contrast)
    return clear[:_SHOWN]


def operating_variables(log: Measured, rig: Rig) -> dict[str, Array]:
    """What an imbalance may depend on, at every row."""
    return dict(_variables(log, rig))


def _variables(log: Measured, rig: Rig) -> Iterator[tuple[str, Array]]:
    span = max(round(0.03 / log.period_s), 3)
    for number, joint in enumerate(rig.joints):
        position, command = bridged(log.channels[f"{joint}.position"].values), log.commands_V[:, number]
        velocity = np.gradient(np.convolve(position, np.ones(span) / span, mode="same"), log.period_s)
        velocity[:span], velocity[-span:] = velocity[span], velocity[-span - 1]
        yield f"{joint}.velocity", velocity
        yield f"{joint}.command_V", command
        yield f"{joint}.position", position
        yield f"time since {joint} reversed", _since_reversal(velocity, log.period_s)
        names = [name for name in (f"{joint}.pressure_a", f"{joint}.pressure_b") if name in log.channels]
        pressures = {name: bridged(log.channels[name].values) for name in names}
        if len(pressures) == 2:
            yield f"pressure difference at {joint}", pressures[names[0]] - pressures[names[1]]
            yield f"lower pressure at {joint}", np.minimum(*pressures.values())
        else:
            yield from pressures.items()
    yield "time", log.t_s


def _since_reversal(velocity: Array, period_s: float) -> Array:
    rows = np.arange(len(velocity))
    turned = np.concatenate([[True], np.diff(np.sign(velocity)) != 0])
    return np.asarray((rows - np.maximum.accumulate(np.where(turned, rows, 0))) * period_s)


def _binned(balance: Balance, name: str, values: Array, seed: int) -> Dependence | None:
    good = np.isfinite(values)
    values, residual = values[good], balance.residual[good]
    edges = np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1))) if values.size else np.empty(0)
    if len(edges) < 3:
        return None
    bins = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    counts = np.bincount(bins, minlength=len(edges) - 1)
    if counts.min() < _LEAST:
        return None
    means = np.bincount(bins, residual, minlength=len(counts)) / counts
    sd = _spread(bins, residual, len(counts), seed)
    low, high = int(np.argmin(means)), int(np.argmax(means))
    contrast = float((means[high] - means[low]) / max(np.hypot(sd[low], sd[high]), 1e-300))
    return Dependence(name, balance.unit, edges, means, 1.96 * sd, contrast)


def _spread(bins: NDArray[np.int64], residual: Array, count: int, seed: int) -> Array:
    """Standard deviation of each bin's mean when blocks of neighbouring supports are drawn again."""
    starts = np.arange(0, len(residual), _BLOCK)
    sums = np.array([np.bincount(bins[a : a + _BLOCK], residual[a : a + _BLOCK], minlength=count) for a in starts])
    numbers = np.array([np.bincount(bins[a : a + _BLOCK], minlength=count) for a in starts])
    picks = np.random.default_rng(seed).integers(0, len(starts), (BOOTSTRAPS, len(starts)))
    drawn = sums[picks].sum(axis=1) / np.maximum(numbers[picks].sum(axis=1), 1)
    return np.asarray(drawn.std(axis=0))


def short(value: float) -> float:
    """Four digits, for a file that is read."""
    return float(f"{value:.4g}")
