"""What the named effects leave over: how much, in which channel, and which input carries it. Nothing of it enters the model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from config.rig import Rig
from gap.evaluation import Evaluation, mean_cost
from gap.localise import operating_values
from gap.measured import Array

LEAST = 0.05  # noise floors of excess that are worth a description
OF_THE_GAP = 0.10  # share of the first excess, too
BINS = 8
LEAST_SHARE = 0.05  # of the residual's variance, for an input to be said to carry something
MOST = 3


def remainder(before: Sequence[Evaluation], after: Sequence[Evaluation], names: Sequence[str], rig: Rig) -> dict[str, Any] | None:
    """None where nothing is left. Else `excess` (noise floors), `channel` with its share of it, and up to three inputs, each with the
    share of that channel's residual variance that a step function of it explains (inputs after the first: of what the first leave)."""
    excess = mean_cost(after) - 1.0
    if excess <= max(OF_THE_GAP * (mean_cost(before) - 1.0), LEAST):
        return None
    over = np.maximum(np.mean([e.channel_costs for e in after], axis=0) - 1.0, 0.0)
    worst = int(np.argmax(over))
    carried = [{"input": name, "share": round(share, 3)} for name, share in _carriers(after, worst, rig)]
    share = round(float(over[worst] / max(over.sum(), 1e-12)), 3)
    return {"excess": round(excess, 4), "channel": names[worst], "share": share, "carried_by": carried}


def sentence(rest: dict[str, Any]) -> str:
    """For a reader: which input carries how much."""
    inputs = ", ".join(f"{item['input']} ({item['share']:.0%})" for item in rest["carried_by"]) or "no single input"
    most = f"shows most in {rest['channel']} ({rest['share']:.0%})"
    return f"What is left ({rest['excess']:.3g} noise floors) {most}; it is carried by {inputs}."


def _carriers(evaluations: Sequence[Evaluation], channel: int, rig: Rig) -> Iterator[tuple[str, float]]:
    """Inputs by how much of the residual a step function of each explains, one after the other."""
    parts = [e.left[:, : e.experiment.measured[0].size].reshape(e.experiment.measured.shape)[:, :, channel].ravel() for e in evaluations]
    left = np.concatenate(parts)
    values = [_inputs(e, rig) for e in evaluations]
    inputs = {name: np.concatenate([v[name].ravel() for v in values]) for name in values[0]}
    good = np.isfinite(left) & np.all([np.isfinite(x) for x in inputs.values()], axis=0)
    left, inputs = left[good] - left[good].mean(), {name: x[good] for name, x in inputs.items()}
    for _ in range(MOST):
        steps = {name: _step_function(x, left) for name, x in inputs.items()}
        name = max(steps, key=lambda key: float(steps[key] @ steps[key]))
        share = float(steps[name] @ steps[name]) / max(float(left @ left), 1e-300)
        if share < LEAST_SHARE:
            return
        yield name, share
        left = left - steps.pop(name)
        del inputs[name]
        if not inputs:
            return


def _inputs(evaluation: Evaluation, rig: Rig) -> dict[str, Array]:
    found = dict(operating_values(evaluation, rig))
    found |= {f"sign of {name}": np.sign(x) for name, x in found.items() if name.endswith(".velocity")}
    return found | {"time": evaluation.experiment.times_s, "time in the window": _in_window(evaluation)}


def _in_window(evaluation: Evaluation) -> Array:
    times = evaluation.experiment.times_s
    return np.asarray(times - times[:, :1])


def _step_function(x: Array, left: Array) -> Array:
    """Mean of `left` in every bin of x, at every value; bins hold equally many."""
    levels = np.unique(x)
    inner = levels[1:] if len(levels) <= BINS else np.unique(np.quantile(x, np.linspace(0, 1, BINS + 1)[1:-1]))
    bins = np.searchsorted(inner, x, side="right")
    counts = np.maximum(np.bincount(bins), 1)
    return np.asarray((np.bincount(bins, left) / counts)[bins])
