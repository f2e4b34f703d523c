"""What the improved model still lacks, in the equation where it lacks it: a smooth discrepancy over the operating variables.

Of every balance equation that the hold-out allows to be formed, the one that comes out even least with the improved rig file; its
imbalance (a force, a flow) is described by splines. It says where to look for physics that has no name yet and enters no rig file unasked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from config.schema.rig import Rig
from gap.balance.additive import LEAST_SHARE, MOST, Curve, additive, alone
from gap.balance.balances import Balance, balances
from gap.balance.dependence import operating_variables, short
from gap.data.measured import Array, Measured
from gap.data.noise import noise_floors

UNEVEN = 2.0  # standard deviations of the imbalance, root mean square, from which there is something to describe
RUBBING = "friction over "  # how an input is called that carries the imbalance times the direction of motion
_BLOCK = 10  # neighbouring supports that are predicted together


def discrepancy(logs: Sequence[Measured], rig: Rig, equations: str = "", uneven: float = UNEVEN) -> dict[str, Any] | None:
    """None where every equation that can be formed (of those that begin with `equations`) holds, to within `uneven`. Else `equation`,
    `unit`, `imbalance` (root mean square), `imbalance_z` (in standard deviations) and `carried_by`: inputs with the share of the
    imbalance's variance and the curve (`at`, `value`) of each; an input "friction over J.position" is the imbalance against the motion."""
    found = {key: parts for key, parts in _formed(logs, rig).items() if _title(key).startswith(equations)}
    worst = max(found, key=lambda key: _z(found[key]), default=None)
    if worst is None or _z(found[worst]) < uneven:
        return None
    parts = found[worst]
    imbalance = np.concatenate([balance.residual for _, balance in parts])
    values = [operating_variables(log, rig) for log, _ in parts]
    shared = [name for name in values[0] if all(name in v for v in values)]
    inputs = {name: np.concatenate([v[name][b.rows] for v, (_, b) in zip(values, parts, strict=True)]) for name in shared}
    inputs |= {f"sign of {name}": np.sign(x) for name, x in inputs.items() if name.endswith(".velocity")}
    good = np.isfinite(imbalance) & np.all([np.isfinite(x) for x in inputs.values()], axis=0)
    blocks = np.arange(len(imbalance)) // _BLOCK
    known = {name: x[good] for name, x in inputs.items()}
    curves = additive(imbalance[good], known, blocks[good])
    if worst[0] == "force balance":
        curves = _with_friction(curves, imbalance[good], worst[1], known, blocks[good])
    return {
        "equation": _title(worst),
        "unit": parts[0][1].unit,
        "imbalance": short(float(np.sqrt(np.mean(imbalance[good] ** 2)))),
        "imbalance_z": round(_z(parts), 1),
        "carried_by": [_curve(c.name, c.share, c.at, c.value) for c in curves],
    }


def _with_friction(
    curves: list[Curve], imbalance: Array, joint: str, inputs: Mapping[str, Array], blocks: NDArray[np.int64]
) -> list[Curve]:
    """Before them friction that changes with the position, a function of two variables, where it carries more than any input alone."""
    turned = (imbalance - imbalance.mean()) * np.sign(inputs[f"{joint}.velocity"])
    rubbing = alone(turned, f"{RUBBING}{joint}.position", inputs[f"{joint}.position"], blocks)
    beaten = max((curve.share for curve in curves), default=LEAST_SHARE)
    return [rubbing, *curves[: MOST - 1]] if rubbing.share > beaten else curves


def _title(key: tuple[str, str]) -> str:
    equation, where = key
    return f"{equation} of {where}"


def _formed(logs: Sequence[Measured], rig: Rig) -> Mapping[tuple[str, str], list[tuple[Measured, Balance]]]:
    """Every equation with its balances, one a log."""
    sigma, found = noise_floors(logs, rig), dict[tuple[str, str], list[tuple[Measured, Balance]]]()
    for log in logs:
        for balance in balances(log, rig, sigma):
            found.setdefault((balance.equation, balance.where), []).append((log, balance))
    return found


def _z(parts: Sequence[tuple[Measured, Balance]]) -> float:
    """Of all logs together."""
    return float(np.sqrt(np.mean(np.concatenate([(balance.residual / balance.sd) ** 2 for _, balance in parts]))))


def _curve(name: str, share: float, at: Array, value: Array) -> dict[str, Any]:
    return {"input": name, "share": round(share, 3), "at": [short(v) for v in at], "value": [short(v) for v in value]}
