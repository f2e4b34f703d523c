"""The common scale of areas, flows, masses and forces, of which logs show next to nothing: the priors decide it.

Areas, volumes and flows twice as large, masses and friction too: the same motion at the same pressures. Finite differences do not see that
the sensitivities cancel there. Their errors, times a signal of thousands of standard deviations, look like knowledge: a fit ends beside
the scale that the priors want, and its interval is far too narrow. So the direction is taken from the units (docs/method/gap-score.md), and
what the logs show along it from a simulation at another scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from gap.data.measured import Array
from gap.fitting.evaluation import Costing, Evaluation, evaluate
from gap.fitting.fit import Fit, objective
from gap.fitting.model import Free, Model, Path, with_values

_POWERS = {
    "kg": 1.0, "kg*m^2": 1.0, "kg/m": 1.0, "N": 1.0, "N*m": 1.0, "N/m": 1.0, "N*m/rad": 1.0, "N*s/m": 1.0, "N*m*s/rad": 1.0, "N*m^2": 1.0,
    "N/Pa": 1.0, "N*m/Pa": 1.0, "m^2": 1.0, "m^3": 1.0, "m^3/rad": 1.0, "m^3/s": 1.0, "m^3/s/Pa": 1.0, "1/m^3": -1.0, "Pa*s^2/m^6": -2.0,
}  # fmt: skip
_OF_A_DIAMETER = 0.5
_TRIED = 0.01  # change of the scale for which readings are compared
_FARTHEST = 0.5  # change of the scale's logarithm


def at_own_scale(done: Fit, costs: Costing) -> Fit:
    """The fit at the common scale that priors and logs want together, with sensitivities that agree with what the logs show of it. The same
    fit where these show more of it than the priors know: a drive of known force, a mass that is held."""
    powers = np.array([_power(free) for free in done.model.free])
    if not powers.any():
        return done
    other = _evaluated(_with_stops(_scaled(done.model, powers, _TRIED), _TRIED), done.evaluations, costs)
    pairs = list(zip(other, done.evaluations, strict=True))
    shown = [(a.left - b.left) / -_TRIED for a, b in pairs], [(a.readings - b.readings) / _TRIED for a, b in pairs]
    if _square(done, costs, shown[0]) > _known(done.model, powers):
        return done
    step = _wanted(done, costs, powers, shown[0])
    model = _scaled(done.model, powers, step)
    now = _evaluated(model, done.evaluations, costs)
    if objective(model, now, costs) >= objective(done.model, done.evaluations, costs):
        model, now, step = done.model, done.evaluations, 0.0
    way, shrunk = powers * model.theta / model.scales, np.exp(-powers * step)
    columns, jacobian = (
        _agreeing([_along(shrunk, part) * part for part in parts], way, slopes)
        for parts, slopes in zip((done.columns, done.jacobian), shown, strict=True)
    )
    return replace(done, model=model, evaluations=now, jacobian=jacobian, columns=columns, objective=objective(model, now, costs))


def _power(free: Free) -> float:
    """Of the scale, in a constant or an effect's parameter."""
    return _OF_A_DIAMETER if free.path[-1] in ("bore_m", "rod_m") else _POWERS.get(free.unit, 0.0)


def _scaled(model: Model, powers: Array, log_scale: float) -> Model:
    return model.with_theta(model.theta * np.exp(log_scale * powers))


def _with_stops(model: Model, log_scale: float) -> Model:
    """Its stops scaled as well: their stiffness is assumed, and held in every fit, so that it must not tell the scale."""
    plant = model.rig.plant
    assert plant is not None
    harder: dict[Path, float] = {
        ("joints", name, "stop_stiffness"): float(joint.stop_stiffness * np.exp(log_scale)) for name, joint in plant.joints.items()
    }
    return replace(model, rig=model.rig.model_copy(update={"plant": with_values(plant, harder)}))


def _evaluated(model: Model, like: Sequence[Evaluation], costs: Costing) -> tuple[Evaluation, ...]:
    return tuple(evaluate(e.experiment, model, costs, e.projection) for e in like)


def _square(done: Fit, costs: Costing, slopes: Sequence[Array]) -> float:
    """What the logs know of the logarithm of the scale: one over its variance."""
    return sum(float(np.sum(s * s)) for s in slopes) / (max(1.0, done.cost) * costs.tau)


def _known(model: Model, powers: Array) -> float:
    """The same of the priors."""
    prior = np.array([1.0 if free.prior else 0.0 for free in model.free])
    return float(np.sum(prior * (powers * model.theta / model.scales) ** 2))


def _wanted(done: Fit, costs: Costing, powers: Array, slopes: Sequence[Array]) -> float:
    """Logarithm of the change of scale at which constants and logs (along a straight line) agree best, within the constants' ranges."""
    square, temper = _square(done, costs, slopes), max(1.0, done.cost) * costs.tau
    linear = sum(float(np.sum(s * e.left)) for s, e in zip(slopes, done.evaluations, strict=True)) / temper
    low, high = -_FARTHEST, _FARTHEST
    for free, value, power in zip(done.model.free, done.model.theta, powers, strict=True):
        if power and free.prior and free.low / value > 0.0:
            a, b = sorted((np.log(free.low / value) / power, np.log(free.high / value) / power))
            low, high = max(low, min(a, 0.0)), min(high, max(b, 0.0))

    def cost(x: float) -> float:
        return float(np.sum(_scaled(done.model, powers, x).pulls ** 2)) + x * x * square - 2.0 * x * linear

    return float(minimize_scalar(cost, bounds=(low, high), method="bounded").x) if low < high else 0.0


def _agreeing(parts: list[Array], way: Array, slopes: Sequence[Array]) -> tuple[Array, ...]:
    """Sensitivities (one array a log, numbers first), each changed by the least share of itself, that give `slopes` along `way`."""
    energy = sum(np.sum(part**2, axis=tuple(range(1, part.ndim))) for part in parts)
    weights = way * energy
    total = float(weights @ way)
    if total == 0.0:
        return tuple(parts)
    return tuple(
        part + _along(weights / total, part) * (slope - np.tensordot(way, part, 1))[None] for part, slope in zip(parts, slopes, strict=True)
    )


def _along(numbers: Array, part: Array) -> Array:
    return np.asarray(numbers.reshape(-1, *([1] * (part.ndim - 1))))
