"""A set of suspects fitted to its end: Gauss-Newton on ln p(y, φ), the discrepancy found anew at every step.

A simulation that is wrong leaves a large residual; the discrepancy grows with it, so that the data weigh little until the model is right.
That is all the damping most fits need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap.data.measured import Array
from gap.evidence.noise.noise_model import Discrepancy
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.coordinates import magnitudes, phi_of, slopes, theta_of
from gap.evidence.score.hypothesis import Hypothesis, Point, Posterior, Seen, Suspect, hypothesis_at, log_density, posterior, rediscovered
from gap.evidence.score.prior import prior_of
from gap.evidence.sensitivity import renewed
from gap.fitting.bounded_step import bounded
from gap.fitting.fit import HALF
from gap.fitting.model import Model
from gap.fitting.sensitivity import shares_of_missed

_STEPS = 12  # Gauss-Newton steps of one fit
_DAMPINGS = (0.0, 1.0, 10.0, 1e2, 1e3, 1e4)  # Levenberg-Marquardt, times the prior's precision: until ln p gains less by one
_ENOUGH = 0.3  # of ln p: a step that gains less ends the fit
FEW_PASSES, MOST_PASSES = 2, 8  # of fits with sensitivities taken anew: before it is known that a fit is worth more, and at most
_MAGNITUDES = (-1.0, -0.6, -0.3, 0.3, 0.6, 1.0)  # in standard deviations of the logarithm
_SETTLED = 0.5  # of ln Z: a descent with fresh sensitivities that gains less was the last


def _point_of(seen: Seen, model: Model, discrepancy: Discrepancy, known: Sequence[Array] = ()) -> Point:
    """A model as it stands, with a discrepancy. `known`: sensitivities of its first numbers, one Jacobian a log; the others are taken."""
    readings = seen.readings(model)
    new = range(known[0].shape[0] if known else 0, len(model.free))
    jacobian = [in_noise(e, m) for e, m in zip(seen.experiments, slopes(model, seen.experiments, new, readings), strict=True)]
    if known:
        jacobian = [np.concatenate(pair) for pair in zip(known, jacobian, strict=True)]
    return Point(model, readings, tuple(jacobian), discrepancy)


def opened(seen: Seen, model: Model, discrepancy: Discrepancy) -> Point:
    """A model as it stands, all sensitivities taken."""
    return _with_discrepancy(seen, _point_of(seen, model, discrepancy), False)


def with_columns(seen: Seen, model: Model, known: Sequence[Array], discrepancy: Discrepancy) -> Point:
    """The same with the first numbers' sensitivities known: `known`, one Jacobian a log. Only those of the other numbers are taken."""
    return _with_discrepancy(seen, _point_of(seen, model, discrepancy, known), True)


def descended(seen: Seen, point: Point) -> Point:
    """Gauss-Newton from a point, its sensitivities following by Broyden's update."""
    for _ in range(_STEPS):
        further, gained = _step(seen, point, posterior(seen, point))
        if further is None:
            break
        if gained < _ENOUGH:
            return further
        point = _with_discrepancy(seen, further, True)
    return point


def by_magnitude(seen: Seen, point: Point) -> Point:
    """The point with every number of which only the magnitude is known at the best of several magnitudes, one number after the other: no
    straight line leads from a soft contact to a stiff one."""
    point = _with_discrepancy(seen, point, True)
    value = log_density(seen, point)
    for k in magnitudes(point.model):
        tried = _with_discrepancy(seen, max(_of_magnitudes(seen, point, k), key=lambda one: log_density(seen, one)), True)
        gained = log_density(seen, tried) - value
        if gained > 0.0:
            point, value = tried, value + gained
    return point


def _of_magnitudes(seen: Seen, point: Point, number: int) -> list[Point]:
    """The point with one number at each magnitude, all else as it is."""
    prior, found = prior_of(point.model), []
    for at in np.clip(_MAGNITUDES, prior.low[number], prior.high[number]):
        phi = phi_of(point.model)
        phi[number] = at
        found.append(_moved(seen, point, phi))
    return found


def hypothesis_of(seen: Seen, suspects: tuple[Suspect, ...], point: Point) -> Hypothesis:
    """A set at a point, the discrepancy looked for in the whole of its range."""
    return hypothesis_at(seen, suspects, _with_discrepancy(seen, point, False))


def finished(seen: Seen, suspects: tuple[Suspect, ...], point: Point, passes: int = MOST_PASSES) -> Hypothesis:
    """The fit with sensitivities of its own, taken anew until a descent with fresh ones gains next to nothing, or what it has gained is
    nothing once they are taken again; or for some passes. What older ones made of the evidence counts for nothing."""
    best: Hypothesis | None = None
    for _ in range(passes):
        # Only the sensitivities are new here: what the point leaves, and so its discrepancy, is as it was.
        fresh = hypothesis_at(seen, suspects, renewed(seen, point))
        if best and fresh.log_z < best.log_z + _SETTLED:
            return replace(max(best, fresh, key=lambda h: h.log_z), ended=True)
        best, found = fresh, hypothesis_of(seen, suspects, descended(seen, fresh.at))
        if found.log_z < fresh.log_z + _SETTLED:
            return replace(max(fresh, found, key=lambda h: h.log_z), ended=True)
        point = found.at
    return replace(found, ended=passes >= MOST_PASSES)


def _with_discrepancy(seen: Seen, point: Point, near: bool) -> Point:
    return replace(point, discrepancy=rediscovered(seen, point, None, near))


def _step(seen: Seen, point: Point, at: Posterior) -> tuple[Point | None, float]:
    """The Gauss-Newton step, damped until it keeps half of its promise, promises next to nothing or is past the best; the point, and by how
    much ln p(y, φ) grows with Σ as it is. Damping is a narrower prior about the point: what the logs hardly know moves farthest, beyond
    where lines hold, so it is held first."""
    prior, phi = prior_of(point.model), phi_of(point.model)
    found, gained = None, 0.0
    for damping in _DAMPINGS:
        damped = at.precision + damping * np.diag(prior.precision)
        step = bounded(damped, at.slope, prior.low - phi, prior.high - phi)
        promised = float(at.slope @ step - 0.5 * step @ at.precision @ step)
        tried, gain = _tried(seen, point, at, damped, step, HALF * promised)
        if gain > gained:
            found, gained = tried, gain
        elif found is not None:
            break
        if gain > HALF * promised or promised < _ENOUGH:
            break
    return (None if found is None else _followed(seen, point, found, at.precision)), gained


def _tried(seen: Seen, point: Point, at: Posterior, damped: Array, step: Array, enough: float) -> tuple[Point, float]:
    """A step, straight or, where that gains less than enough and it is better, bent; and what it gains, −∞ where nothing finite."""
    prior = prior_of(point.model)
    straight = _moved(seen, point, np.clip(phi_of(point.model) + step, prior.low, prior.high))
    gain = _gain(seen, straight, at)
    if gain > enough or gain == -np.inf:
        return straight, gain
    bent = _bent(seen, point, straight, damped)
    return max((straight, gain), (bent, _gain(seen, bent, at)), key=lambda one: one[1])


def _gain(seen: Seen, point: Point, at: Posterior) -> float:
    gain = log_density(seen, point) - at.log_density
    return gain if np.isfinite(gain) else -np.inf


def _bent(seen: Seen, point: Point, straight: Point, damped: Array) -> Point:
    """A step that follows a valley's bend: what the straight one has missed, solved for with the same sensitivities and taken off
    (geodesic acceleration, over the whole step: Transtrum and Sethna 2012, arXiv:1201.5885)."""
    prior, missed = prior_of(point.model), _missed(seen, point, straight)
    rows = [(m[None], jacobian) for m, jacobian in zip(missed, point.jacobian, strict=True)]
    back = np.linalg.solve(damped, seen.weighed(rows, point.discrepancy).inner[1:, 0])
    return _moved(seen, point, np.clip(phi_of(straight.model) - back, prior.low, prior.high))


def _missed(seen: Seen, point: Point, further: Point) -> list[Array]:
    """What the point's sensitivities did not predict of the change to another point, log by log, in noise."""
    step = phi_of(further.model) - phi_of(point.model)
    lefts = zip(seen.left(point.readings), seen.left(further.readings), point.jacobian, strict=True)
    return [old - new - np.tensordot(step, jacobian, 1) for old, new, jacobian in lefts]


def _moved(seen: Seen, point: Point, phi: Array) -> Point:
    """The point with other numbers, its sensitivities as they were."""
    model = point.model.with_theta(theta_of(point.model, phi))
    return replace(point, model=model, readings=seen.readings(model))


def _followed(seen: Seen, point: Point, further: Point, precision: Array) -> Point:
    """A further point with Broyden's update: the sensitivities that would have predicted the step to it, and else changed least, as the
    posterior measures that. (By plain length, what a short step has missed would look like knowledge along directions of which the logs
    say little.)"""
    shares = shares_of_missed(phi_of(further.model) - phi_of(point.model), precision)
    found = [j + shares[:, None, None, None] * m for j, m in zip(point.jacobian, _missed(seen, point, further), strict=True)]
    return replace(further, jacobian=tuple(found))
