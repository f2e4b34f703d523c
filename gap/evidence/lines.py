"""A set followed along straight lines: the fit that it would have if readings were linear, with the discrepancy found anew. No simulation.

What a suspect explains is discrepancy no more, so its promise beside the old discrepancy is too small. Here constants, suspect and
discrepancy answer each other as in a fit; the result says where the fit should start and what it may hope for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gap.data.measured import Array
from gap.evidence.noise.noise_model import Discrepancy
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import of_other_priors, phi_of, theta_of
from gap.evidence.score.hypothesis import Hypothesis, Point, Seen, evidence, posterior, rediscovered, window_densities
from gap.evidence.score.prior import prior_of
from gap.evidence.screening import LinearSignature, Promise
from gap.evidence.secants import Secant
from gap.fitting.bounded_step import bounded
from gap.fitting.model import Model

_ROUNDS = 2  # of step and discrepancy


@dataclass(frozen=True, slots=True)
class StraightFit:
    """Where straight lines lead, ln Z there, and what every window says of it, as in Hypothesis."""

    model: Model
    discrepancy: Discrepancy
    log_z: float
    windows: Array


def followed(seen: Seen, base: Hypothesis, promise: Promise | None = None) -> StraightFit:
    """The base's set with the suspect, or by itself, as far as straight lines tell."""
    model, jacobian = joined(base, promise) if promise else (base.model, base.at.jacobian)
    point, left = replace(base.at, model=model, jacobian=jacobian), seen.left(base.at.readings)
    at = posterior(seen, point, left)
    for _ in range(_ROUNDS):
        prior, phi = prior_of(point.model), phi_of(point.model)
        step = bounded(at.precision, at.slope, prior.low - phi, prior.high - phi)
        left = [r - np.tensordot(step, j, 1) for r, j in zip(left, jacobian, strict=True)]
        point = replace(point, model=point.model.with_theta(theta_of(point.model, phi + step)))
        before, point = point.discrepancy, _again(seen, point, left)
        at = posterior(seen, point, left)
        if np.allclose(np.log(point.discrepancy.sd), np.log(before.sd), atol=0.1):
            break
    windows = window_densities(seen, left, point.discrepancy)
    return StraightFit(point.model, point.discrepancy, evidence(at, point.model), windows)


def joined(base: Hypothesis, promise: Promise) -> tuple[Model, tuple[Array, ...]]:
    """The base's model with the suspect at its start, and all lines."""
    suspect, jacobian = promise.suspect, base.at.jacobian
    if isinstance(suspect, Changed):
        model = suspect.with_wide_prior(base.model)
        found = [of_other_priors(j, base.model, model) for j in jacobian]
        return model, tuple(_along(promise.signature, model, found) if isinstance(promise.signature, Secant) else found)
    assert isinstance(promise.signature, LinearSignature)
    model = base.model.with_effect(suspect.entry, suspect.free)
    values = [
        value if not any(np.any(c[k]) for c in promise.signature.columns) else suspect.free[k].start
        for k, value in enumerate(promise.signature.values)
    ]  # what does nothing alone stands where it was tried
    model = model.with_theta(np.concatenate([base.model.theta, values]))
    return model, tuple(np.concatenate(pair) for pair in zip(jacobian, promise.signature.columns, strict=True))


def _along(secant: Secant, model: Model, jacobian: list[Array]) -> list[Array]:
    """The lines with the number's own along the secant."""
    number = secant.suspect.number_in(model)
    return [np.concatenate([j[:number], c[None], j[number + 1 :]]) for j, c in zip(jacobian, secant.columns, strict=True)]


def _again(seen: Seen, point: Point, left: list[Array]) -> Point:
    return replace(point, discrepancy=rediscovered(seen, point, left))
