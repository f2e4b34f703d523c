"""One set of effects fitted: where its posterior is largest, how wide it is there, and the evidence for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2, norm

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import CONFIRMED
from gap.evidence.noise.discrepancy import expected, log_prior_of_sizes, log_prior_of_times
from gap.evidence.noise.discrepancy_search import fitted_discrepancy
from gap.evidence.noise.noise_model import Discrepancy, Weighed, by_window, weighed
from gap.evidence.noise.other_form import expected_form
from gap.evidence.noise.unknowns import unknowns_of
from gap.evidence.noise.whitening import Blocks, Whitening
from gap.evidence.score.changed import Changed
from gap.evidence.score.coarsening import power
from gap.evidence.score.coordinates import phi_of
from gap.evidence.score.laplace import log_evidence
from gap.evidence.score.prior import prior_of
from gap.fitting.model import Model
from gap.fitting.simulate import on_logs, remembering, residual
from gap.suspects.candidates import Candidate

Suspect = Candidate | Changed
MOST_HONEST = float(norm.ppf(0.5 + 0.5 * CONFIRMED))  # scales of the discrepancy that CONFIRMED of honest models leave at most


@dataclass(frozen=True, slots=True)
class Seen:
    """What is the same for every set that is compared: `logs` to fit with what is integrated out as it is about one `model`, and the scale
    of each channel's discrepancy. (About a model of its own every set would have another Σ, and sets would gain by that alone.)
    `counts`: ζ, the part of ln p that the logs count for (gap.evidence.score.coarsening)."""

    logs: tuple[Whitening, ...]
    scales: Array
    model: Model
    counts: float

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        return tuple(log.experiment for log in self.logs)

    @property
    def threads(self) -> int:
        """Of the search."""
        return max(self.logs[0].experiment.workers, 1)

    def readings(self, model: Model) -> tuple[Array, ...]:
        """Of every log with a model, windows × samples × channels."""
        return tuple(own[0] for own in on_logs(self.experiments, [model.vector()]))

    def left(self, readings: Sequence[Array]) -> list[Array]:
        """(measured − simulated) / noise of every log, windows × samples × channels; 0 where nothing was measured."""
        return [residual(e, r).reshape(e.measured.shape) for e, r in zip(self.experiments, readings, strict=True)]

    def weighed(self, rows: Sequence[Blocks], discrepancy: Discrepancy) -> Weighed:
        """ζ xᵀΣ⁻¹x of rows x of every log, and ζ ln|Σ|."""
        found = weighed(self.logs, rows, discrepancy)
        return Weighed(self.counts * found.inner, self.counts * found.log_det)


@dataclass(frozen=True, slots=True)
class Point:
    """A model with what it does on every log: `readings`, and `jacobian`: d readings / dφ in units of the noise, numbers × windows ×
    samples × channels."""

    model: Model
    readings: tuple[Array, ...]
    jacobian: tuple[Array, ...]
    discrepancy: Discrepancy


@dataclass(frozen=True, slots=True)
class Posterior:
    """Gauss-Newton's normal at one point: precision and slope of ζ ln p(y | φ) + ln p(φ), and its value."""

    precision: Array
    slope: Array
    log_density: float


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A set of suspects with its model; `windows`: what each window says of it, ζ ln p, one log after the other; `ended`: whether the
    fit has been taken to its end with sensitivities of its own."""

    suspects: tuple[Suspect, ...]
    at: Point
    log_z: float
    windows: Array
    ended: bool = False

    @property
    def labels(self) -> frozenset[str]:
        return frozenset(suspect.label for suspect in self.suspects)

    @property
    def model(self) -> Model:
        return self.at.model


def about(experiments: Sequence[Experiment], scales: Array, model: Model, counts: float) -> Seen:
    """Logs with what is integrated out, and what windows remember, as they are about a model."""
    vector = model.vector()
    remembered = tuple(remembering(e, vector) for e in experiments)
    logs = tuple(Whitening(e, own) for e, own in zip(remembered, unknowns_of(remembered, vector), strict=True))
    return Seen(logs, scales, model, counts)


def about_fit(seen: Seen, fitted: Hypothesis) -> Seen:
    """The same logs as they are about a fitted set, and as what it leaves lets them count."""
    there = about(seen.experiments, seen.scales, fitted.model, seen.counts)
    form = expected_form(there.logs, seen.left(fitted.at.readings), fitted.at.discrepancy)
    excess = 1.0 - (MOST_HONEST / max(float(beyond(seen, fitted).max()), MOST_HONEST)) ** 2
    return replace(there, counts=counted(seen.experiments, form, excess))


def counted(experiments: Sequence[Experiment], form: float, excess: float = 0.0) -> float:
    """ζ of logs in windows; `form` of the friction has another form, `excess` of the discrepancy's variance is beyond honest models."""
    return power(sum(len(e.measured) for e in experiments), form, excess)


def reweighed(seen: Seen, hypothesis: Hypothesis) -> Hypothesis:
    """A fitted set as it is, beside what is integrated out now."""
    point = replace(hypothesis.at, readings=seen.readings(hypothesis.model))
    point = replace(point, discrepancy=rediscovered(seen, point, near=False))
    return replace(hypothesis_at(seen, hypothesis.suspects, point), ended=hypothesis.ended)


def hypothesis_at(seen: Seen, suspects: tuple[Suspect, ...], point: Point) -> Hypothesis:
    """A set at a point, its evidence and what every window adds to that."""
    log_z = evidence(posterior(seen, point), point.model)
    return Hypothesis(suspects, point, log_z, window_densities(seen, seen.left(point.readings), point.discrepancy))


def window_densities(seen: Seen, left: Sequence[Array], discrepancy: Discrepancy) -> Array:
    """What each window says of residuals, ζ ln p, one log after the other."""
    return np.asarray(seen.counts * (by_window(seen.logs, left, discrepancy) + log_prior_of_times(discrepancy)))


def honest(seen: Seen, hypothesis: Hypothesis) -> Hypothesis:
    """The same beside the discrepancy that is expected of an honest model, alike in all windows."""
    was = hypothesis.at.discrepancy
    discrepancy = expected(seen.scales, was.share, was.contact)
    return hypothesis_at(seen, hypothesis.suspects, replace(hypothesis.at, discrepancy=discrepancy))


def beyond(seen: Seen, hypothesis: Hypothesis, most: float = MOST_HONEST) -> Array:
    """Of every channel whose discrepancy is more than `most` times its scale, how many times; else 0."""
    ratio = hypothesis.at.discrepancy.sd / seen.scales
    return np.where(ratio > most, ratio, 0.0)


def doubtful(seen: Seen, hypothesis: Hypothesis) -> bool:
    """Whether a set leaves more than honest models leave, or its constants have gone too far from the rig file's to leave less."""
    return bool(np.any(beyond(seen, hypothesis))) or strained(seen, hypothesis)


def strained(seen: Seen, hypothesis: Hypothesis) -> bool:
    """Whether constants lie farther from the rig file's than those of CONFIRMED of all machines: Σφ² is about χ² with as many degrees of
    freedom as the logs determine numbers (MacKay 2003, sec. 28.1: γ = d − tr H⁻¹ of their priors' precisions)."""
    own = np.array([f.prior for f in hypothesis.model.free])
    precision = prior_of(hypothesis.model).precision
    unsure = precision * np.diag(np.linalg.inv(posterior(seen, hypothesis.at).precision))
    determined = float(np.sum(1.0 - unsure[own]))
    pulls = float(np.sum(precision[own] * phi_of(hypothesis.model)[own] ** 2))
    return bool(pulls > chi2.ppf(CONFIRMED, max(determined, 1.0)))


def posterior(seen: Seen, point: Point, left: Sequence[Array] | None = None) -> Posterior:
    """The normal approximation at a point; `left`: its residuals where they are known better than from its readings."""
    left = seen.left(point.readings) if left is None else left
    rows = [(r[None], j) for r, j in zip(left, point.jacobian, strict=True)]
    found = seen.weighed(rows, point.discrepancy)
    prior, phi = prior_of(point.model), phi_of(point.model)
    precision, slope = found.inner[1:, 1:] + np.diag(prior.precision), found.inner[1:, 0] - prior.precision * phi
    return Posterior(precision, slope, _density(seen, point, found))


def log_density(seen: Seen, point: Point) -> float:
    """ζ ln p(y | φ) + ln p(φ) at a point."""
    found = seen.weighed([(r[None],) for r in seen.left(point.readings)], point.discrepancy)
    return _density(seen, point, found)


def _density(seen: Seen, point: Point, found: Weighed) -> float:
    prior = prior_of(point.model).log_density(phi_of(point.model)) + log_prior_of_sizes(point.discrepancy, seen.scales)
    prior += seen.counts * float(log_prior_of_times(point.discrepancy).sum())
    return prior - 0.5 * (float(found.inner[0, 0]) + found.log_det)


def evidence(at: Posterior, model: Model) -> float:
    """ln Z of the normal approximation at a model."""
    prior = prior_of(model)
    return log_evidence(at.log_density, at.precision, at.slope, phi_of(model), prior.low, prior.high)


def rediscovered(seen: Seen, point: Point, left: Sequence[Array] | None = None, near: bool = True) -> Discrepancy:
    """The discrepancy at a point, from the one it has; `near` as for fitted_discrepancy."""
    left = seen.left(point.readings) if left is None else left
    return fitted_discrepancy(seen.logs, left, seen.scales, point.discrepancy, near)
