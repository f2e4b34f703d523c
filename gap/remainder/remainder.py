"""What the named effects leave over: how much, in which channel, in which equation, and which input carries it. Nothing of it enters
the model, unless it is to be kept (gap.remainder.kept_remainder)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from config.schema.rig import Rig
from gap.balance.additive import Curve, additive
from gap.balance.discrepancy import discrepancy
from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation, mean_channel_costs, mean_cost
from gap.outcome.localise import operating_values

LEAST = 0.05  # noise floors of excess that are worth a description
OF_THE_GAP = 0.10  # share of the first excess, too


def remainder(before: Sequence[Evaluation], after: Sequence[Evaluation], names: Sequence[str], rig: Rig) -> dict[str, Any] | None:
    """None where nothing is left. Else `excess` (noise floors), `channel` with its share of it, and up to three inputs, each with the
    share of that channel's residual variance that a spline over it predicts (inputs after the first: of what the first leave);
    `discrepancy`: the same in the equation that holds least with `rig`, the improved one, where one can be formed."""
    excess = mean_cost(after) - 1.0
    if excess <= max(OF_THE_GAP * (mean_cost(before) - 1.0), LEAST):
        return None
    over = np.maximum(mean_channel_costs(after) - 1.0, 0.0)
    worst = int(np.argmax(over))
    carried = [{"input": curve.name, "share": round(curve.share, 3)} for curve in _carriers(after, worst, rig)]
    share = round(float(over[worst] / max(over.sum(), 1e-12)), 3)
    equation = discrepancy([e.experiment.log for e in after], rig)
    return {"excess": round(excess, 4), "channel": names[worst], "share": share, "carried_by": carried, "discrepancy": equation}


def sentence(rest: dict[str, Any]) -> str:
    """For a reader: which input carries how much."""
    most = f"shows most in {rest['channel']} ({rest['share']:.0%})"
    said = f"What is left ({rest['excess']:.3g} noise floors) {most}; it is carried by {_listed(rest)}."
    found = rest["discrepancy"]
    if found is None:
        return said
    size = f"an rms of {found['imbalance']:g} {found['unit']}, {found['imbalance_z']:g} standard deviations"
    return f"{said} The {found['equation']} comes out uneven ({size}), carried by {_listed(found)}."


def _listed(carried: dict[str, Any]) -> str:
    return ", ".join(f"{item['input']} ({item['share']:.0%})" for item in carried["carried_by"]) or "no single input"


def _carriers(evaluations: Sequence[Evaluation], channel: int, rig: Rig) -> list[Curve]:
    """Inputs that carry what is left of a channel; a window is a block."""
    parts = [e.left[:, : e.experiment.measured[0].size].reshape(e.experiment.measured.shape)[:, :, channel] for e in evaluations]
    left = np.concatenate([part.ravel() for part in parts])
    blocks = np.concatenate([np.repeat(np.arange(len(part)), part.shape[1]) for part in parts])
    values = [_inputs(e, rig) for e in evaluations]
    inputs = {name: np.concatenate([v[name].ravel() for v in values]) for name in values[0]}
    good = np.isfinite(left) & np.all([np.isfinite(x) for x in inputs.values()], axis=0)
    return additive(left[good], {name: x[good] for name, x in inputs.items()}, blocks[good])


def _inputs(evaluation: Evaluation, rig: Rig) -> dict[str, Array]:
    found = dict(operating_values(evaluation, rig))
    found |= {f"sign of {name}": np.sign(x) for name, x in found.items() if name.endswith(".velocity")}
    return found | {"time": evaluation.experiment.times_s, "time in the window": _in_window(evaluation)}


def _in_window(evaluation: Evaluation) -> Array:
    times = evaluation.experiment.times_s
    return np.asarray(times - times[:, :1])
