"""value = offset + scale × counts by least squares over points at known values, with what limits how far it can be believed.

Expanded uncertainty of one reading between the points (95.45 %, as k = 2 has it of many points): Student's t times the root of the sum
of squares of what the points scatter by about the line, s √(1 + 1/n + (x − x̄)²/Sxx) at the outermost point (N. Draper and H. Smith,
Applied Regression Analysis, 1998, 3.1), of the readings' noise, of the reference, and of a count's rounding, |scale| / sqrt(12). Degrees
of freedom by Welch and Satterthwaite (GUM G.4.2): s has n − 2. Two points scatter by nothing; only a stated reference tells of theirs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy.special import stdtrit

from config.errors import ConfigError, Refusal
from config.stated_sentences import Conversion
from tuning.arrays import Floats

LEAST_COUNTS = 100  # between the outermost points: rounding then turns the scale by less than 1 %
NOISE_SHARE, RESIDUAL_SHARE = 0.001, 0.005  # of the span of the known values, unless the user says otherwise
TWO_SIGMAS = 0.97725  # of a normal distribution lie below
_OF_A_COUNT = 1e-6  # less is what the arithmetic leaves


@dataclass(frozen=True, slots=True)
class ReferencePoint:
    """Readings at one known value (SI): their mean, standard deviation and number. One reading given by hand has no noise."""

    value: float
    counts: float
    sd: float = 0.0
    readings: int = 1


@dataclass(frozen=True, slots=True)
class Limits:
    """Largest noise and residual, and the reference's own standard uncertainty, all in the unit of the values; None: the default share."""

    noise: float | None = None
    residual: float | None = None
    reference: float = 0.0


@dataclass(frozen=True, slots=True)
class SensorCalibration:
    """`residuals`: known value less the line's, by point. `noise`: pooled standard deviation of one reading, as a value.
    `uncertainty`: None where two points and no reference leave it unknown."""

    points: tuple[ReferencePoint, ...]
    scale: float
    offset: float
    residuals: tuple[float, ...]
    noise: float
    uncertainty: float | None

    @property
    def span(self) -> float:
        values = [point.value for point in self.points]
        return max(values) - min(values)

    @property
    def noise_is_known(self) -> bool:
        return any(point.readings > 1 for point in self.points)

    @property
    def worst_residual(self) -> float:
        return max(map(abs, self.residuals))


def calibrated(points: Sequence[ReferencePoint], limits: Limits, shown: Conversion, where: str, watch: str) -> SensorCalibration:
    """The calibration. ConfigError, with every reason as values are `shown`, when noise, residual or the points do not allow one.

    `watch`: the command that shows the readings live."""
    _refuse([*_of_points(points, where, watch)], where)
    values = np.array([point.value for point in points])
    counts = np.array([point.counts for point in points])
    middle = counts.mean()  # counts of an absolute encoder are large: the line is fitted about their middle
    scale, at_middle = np.polyfit(counts - middle, values, 1)
    offset = at_middle - scale * middle
    residuals = values - (offset + scale * counts)
    residuals[np.abs(residuals) < _OF_A_COUNT * abs(scale)] = 0.0
    noise = abs(scale) * _pooled(points)
    known = noise**2 + limits.reference**2 + scale**2 / 12.0
    uncertainty = _expanded(counts, residuals, known, limits.reference)
    found = SensorCalibration(tuple(points), float(scale), float(offset), tuple(map(float, residuals)), float(noise), uncertainty)
    _refuse([*_of_line(found, limits, shown, where)], where)
    return found


def _expanded(counts: Floats, residuals: Floats, known: float, reference: float) -> float | None:
    """`known`: variance of one reading beside that of the points about the line."""
    away = counts - counts.mean()
    of_the_line = 1.0 / len(counts) + float(np.max(away**2) / (away @ away))
    free = len(counts) - 2
    if not free:
        return 2.0 * sqrt(known + of_the_line * reference**2) if reference else None
    scatter = (1.0 + of_the_line) * float(residuals @ residuals) / free
    if not scatter:
        return 2.0 * sqrt(known)
    return float(stdtrit(free * ((known + scatter) / scatter) ** 2, TWO_SIGMAS)) * sqrt(known + scatter)


def _pooled(points: Sequence[ReferencePoint]) -> float:
    """Standard deviation of one reading, in counts."""
    free = sum(point.readings - 1 for point in points)
    return sqrt(sum((point.readings - 1) * point.sd**2 for point in points) / free) if free else 0.0


def _of_points(points: Sequence[ReferencePoint], where: str, watch: str) -> Iterator[Refusal]:
    values = {point.value for point in points}
    if len(values) < 2:
        advice = "Give two or more, as far apart as the sensor will be used: --at VALUE --at VALUE."
        yield Refusal("readings at different known values are needed", str(len(values)), "at least 2", "", where, advice)
        return
    counts = [point.counts for point in points]
    travelled = max(counts) - min(counts)
    if travelled < LEAST_COUNTS:
        advice = f"Does it move, is it the right channel, are the points far enough apart? `{watch}` shows it live."
        yield Refusal(
            "the readings hardly change between the points", f"{travelled:.6g}", f"at least {LEAST_COUNTS}", "counts", where, advice
        )


def _of_line(found: SensorCalibration, limits: Limits, shown: Conversion, where: str) -> Iterator[Refusal]:
    unit, factor, zero = shown
    noise_limit = NOISE_SHARE * found.span if limits.noise is None else limits.noise
    residual_limit = RESIDUAL_SHARE * found.span if limits.residual is None else limits.residual
    for point in found.points:
        noise = abs(found.scale) * point.sd
        if noise > noise_limit:
            what = f"the readings at {factor * point.value + zero:.6g} {unit} are too noisy (standard deviation)"
            advice = "Hold the joint still, check shield and earth, or allow more with --noise-limit."
            yield Refusal(what, f"{factor * noise:.3g}", f"{factor * noise_limit:.3g}", unit, where, advice)
    for point, residual in zip(found.points, found.residuals, strict=True):
        if abs(residual) > residual_limit:
            what = f"the point {factor * point.value + zero:.6g} {unit} lies off the line of the others"
            advice = "Is a known value wrong, did the counts wrap, is the sensor not linear? Else allow more with --residual-limit."
            yield Refusal(what, f"{factor * residual:.3g}", f"{factor * residual_limit:.3g}", unit, where, advice)


def _refuse(reasons: list[Refusal], where: str) -> None:
    if not reasons:
        return
    if len(reasons) == 1:
        only = reasons[0]
        raise ConfigError(only.what, value=only.value, limit=only.limit, unit=only.unit, where=where, next_step=only.next_step)
    lines = "".join(f"\n  {reason.text()}" for reason in reasons)
    raise ConfigError(f"no calibration of {where}:{lines}", problems=tuple(reasons))
