"""The form of the paper's Eq 4 fitted to a measured response: θ/u = K / (s (s² + a s + b)), with the flexible link where it shows.

link: (s² + 2ζ_z ω_z s + ω_z²)/(s² + 2ζ_p ω_p s + ω_p²) · ω_p²/ω_z²       clamped antiresonance, free resonance
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees, log, pi, radians, sqrt

import numpy as np
from scipy.optimize import least_squares

from config.errors import LogError
from tuning.arrays import Complexes, Floats
from tuning.eq4 import NUMERATOR, PRODUCT_PER_S2, SUM_PER_S
from tuning.responses.frequency_response import FrequencyResponse

LEAST_SIGMA = 0.005  # no response is believed better than this
START = (log(radians(NUMERATOR)), log(SUM_PER_S), log(PRODUCT_PER_S2))  # Eq 4 in radians per volt
LINK_START = (0.97, 0.02, 0.1)  # ω_p/ω_z and the two damping ratios
# What a hydraulic joint can be: without limits the fit takes the joint's poles for the link's. Factors either side for gain, damping and
# stiffness; the antiresonance within 15 % of what the link's constants say. (A hydraulic joint is nearly a source of velocity: the
# resonance lies close to the antiresonance, often a little below it, not where it would be with a free hub.)
JOINT_FACTORS, ZERO_SHARE = (30.0, 10.0, 10.0), 0.15
LINK_LIMITS = ((0.7, 4.0), (1e-3, 0.3), (1e-3, 1.0))
LARGEST_SIGMA = 0.3  # a less certain line is not used
NAMES, LINK_NAMES = ("gain", "damping", "stiffness"), ("antiresonance_Hz", "resonance_ratio", "antiresonance_damping", "resonance_damping")


@dataclass(frozen=True, slots=True)
class JointFit:
    """K in rad (or m) per V·s³, a in 1/s, b in 1/s², by name in `values`, with two standard deviations in `uncertainty` (relative);
    with the link also its four numbers. `velocity_gain` = K/b (per V·s) and `lag_s` = a/b are known better than the three, which compensate
    each other; they are what a feed-forward needs.
    Errors left: largest over the band, in dB and degrees."""

    values: dict[str, float]
    uncertainty: dict[str, float]
    worst_dB: float
    worst_deg: float
    with_link: bool

    @property
    def velocity_gain(self) -> float:
        return self.values["gain"] / self.values["stiffness"]

    @property
    def lag_s(self) -> float:
        return self.values["damping"] / self.values["stiffness"]

    def __call__(self, frequencies_Hz: Floats) -> Complexes:
        return _model(np.log([self.values[name] for name in (*NAMES, *(LINK_NAMES if self.with_link else ()))]), 2.0 * pi * frequencies_Hz)


def fit_joint(response: FrequencyResponse, clamped_Hz: float | None = None, band_Hz: Sequence[float] = (0.0, 1e9)) -> JointFit:
    """Least squares on the logarithm (dB and phase alike), weighted by the response's certainty.

    `clamped_Hz`: where the link's antiresonance is expected; None: Eq 4 alone. LogError for fewer lines than parameters.
    """
    omega, measured, sigma = _believed_lines(response, band_Hz)
    start = [*START, *([log(clamped_Hz), *np.log(LINK_START)] if clamped_Hz is not None else [])]
    if 2 * len(omega) < len(start) + 2:
        raise LogError("too few lines for the fit", value=len(omega), limit=len(start) // 2 + 2, where=f"response of {response.source}")
    weight = 1.0 / np.maximum(sigma, LEAST_SIGMA)
    guess = np.array(start)
    guess[0] += float(np.median(np.log(np.abs(measured) / np.abs(_model(guess, omega)))))

    def misfit(parameters: Floats) -> Floats:
        error = np.log(measured / _model(parameters, omega))
        return np.concatenate([weight * error.real, weight * error.imag])

    best = least_squares(misfit, guess, bounds=_limits(guess), loss="soft_l1", f_scale=3.0)
    left = np.log(measured / _model(best.x, omega))
    names = (*NAMES, *(LINK_NAMES if clamped_Hz is not None else ()))
    return JointFit(
        dict(zip(names, np.exp(best.x).tolist(), strict=True)),
        _uncertainty(names, best.jac, misfit(best.x)),
        float(np.max(np.abs(left.real))) * 20.0 / log(10.0),
        degrees(float(np.max(np.abs(left.imag)))),
        clamped_Hz is not None,
    )


def _believed_lines(response: FrequencyResponse, band_Hz: Sequence[float]) -> tuple[Floats, Complexes, Floats]:
    """Frequency in rad/s, value and relative standard deviation of the lines in the band that are known well enough."""
    used = (response.frequencies_Hz >= band_Hz[0]) & (response.frequencies_Hz <= band_Hz[1]) & (response.sigma < LARGEST_SIGMA)
    return 2.0 * pi * response.frequencies_Hz[used], response.response[used], response.sigma[used]


def _uncertainty(names: Sequence[str], jacobian: Floats, residuals: Floats) -> dict[str, float]:
    """Two relative standard deviations of every parameter, and of the ratios K/b and a/b: (JᵀJ)⁻¹, scaled up where the residuals scatter
    more than their weights say. Relative, because the parameters are logarithms."""
    scatter = float(np.sum(residuals**2)) / max(1, len(residuals) - len(names))
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * max(1.0, scatter)
    deviation = 2.0 * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    gain_ratio, lag_ratio = (covariance[n, n] + covariance[2, 2] - 2.0 * covariance[n, 2] for n in (0, 1))
    ratios = {"velocity_gain": 2.0 * sqrt(max(gain_ratio, 0.0)), "lag": 2.0 * sqrt(max(lag_ratio, 0.0))}
    return {**dict(zip(names, deviation.tolist(), strict=True)), **ratios}


def _limits(guess: Floats) -> tuple[Floats, Floats]:
    """Lower and upper limits of the logarithms."""
    spans = [(-log(factor), log(factor)) for factor in JOINT_FACTORS]
    limits = [(middle + low, middle + high) for middle, (low, high) in zip(guess[:3], spans, strict=True)]
    if len(guess) > 3:
        limits += [(guess[3] + log(1.0 - ZERO_SHARE), guess[3] + log(1.0 + ZERO_SHARE)), *((log(a), log(b)) for a, b in LINK_LIMITS)]
    low, high = np.array(limits).T
    return low, high


def _model(parameters: Floats, omega: Floats) -> Complexes:
    """Value at frequencies in rad/s; parameters are logarithms."""
    gain, damping, stiffness, *link = np.exp(parameters)
    s = 1j * omega
    value = np.asarray(gain / (s * (s**2 + damping * s + stiffness)))
    if not link:
        return value
    zero, ratio, zero_damping, pole_damping = 2.0 * pi * link[0], link[1], link[2], link[3]
    pole = ratio * zero
    top = (s**2 + 2.0 * zero_damping * zero * s + zero**2) / zero**2
    return np.asarray(value * top / (s**2 + 2.0 * pole_damping * pole * s + pole**2) * pole**2, dtype=np.complex128)
