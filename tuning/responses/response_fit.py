"""The form of the paper's Eq 4 fitted to a measured response: θ/u = K / (s (s² + a s + b)), with the flexible link where it shows.

link: (s² + 2ζ_z ω_z s + ω_z²)/(s² + 2ζ_p ω_p s + ω_p²) · ω_p²/ω_z²       clamped antiresonance, free resonance
valve: ω_v²/(s² + 2ζ_v ω_v s + ω_v²)                                        of a single axis, see `axis_fit`
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import degrees, log, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from config.errors import LogError
from tuning.arrays import Complexes, Floats
from tuning.responses.frequency_response import FrequencyResponse

LEAST_SIGMA = 0.005  # no response is believed better than this
OUTLIER_SIGMAS = 3.0  # of a complex value; a line further off counts less
STARTS = (1.0, 2.0, 5.0)  # natural frequency over that of 180 degrees, or over the last line where no line lags so much
DAMPING = (0.01, 5.0)  # ratio, beside the guess of the natural frequency
BESIDE_LINK = 1.4  # a line less than so many times away from the link's frequency says little of the joint
LINK_START = (0.97, 0.02, 0.1)  # ω_p/ω_z and the two damping ratios
# What a hydraulic joint can be: without limits the fit takes the joint's poles for the link's. Factors either side of the guess for gain
# and stiffness; the antiresonance within 15 % of what the link's constants say. (A hydraulic joint is nearly a source of velocity: the
# resonance lies close to the antiresonance, often a little below it, not where it would be with a free hub.)
GAIN_FACTOR, STIFFNESS_FACTOR, ZERO_SHARE = 30.0, 10.0, 0.15
LINK_LIMITS = ((0.7, 4.0), (1e-3, 0.3), (1e-3, 1.0))
LARGEST_SIGMA = 0.3  # a less certain line is not used
NAMES, LINK_NAMES = ("gain", "damping", "stiffness"), ("antiresonance_Hz", "resonance_ratio", "antiresonance_damping", "resonance_damping")
VALVE_NAMES = ("valve_Hz", "valve_damping")
Form = Callable[[Floats, Floats], Complexes]  # logarithms of the parameters, frequencies in rad/s


@dataclass(frozen=True, slots=True)
class JointFit:
    """K in rad (or m) per V·s³, a in 1/s, b in 1/s², by name in `values`, with two standard deviations in `uncertainty` (relative);
    with the link also its four numbers, of a single axis its valve's two. `velocity_gain` = K/b (per V·s) and `lag_s` = a/b are known
    better than the three, which compensate each other; they are what a feed-forward needs.
    Errors left: largest over the band, in dB and degrees. `at_limit`: numbers that ended on a limit of the fit, so that it says no more
    than that they lie there or beyond."""

    values: dict[str, float]
    uncertainty: dict[str, float]
    worst_dB: float
    worst_deg: float
    at_limit: tuple[str, ...] = ()

    @property
    def natural_Hz(self) -> float:
        """√b: of load and oil."""
        return sqrt(self.values["stiffness"]) / (2.0 * pi)

    @property
    def damping_ratio(self) -> float:
        return 0.5 * self.values["damping"] / sqrt(self.values["stiffness"])

    @property
    def velocity_gain(self) -> float:
        return self.values["gain"] / self.values["stiffness"]

    @property
    def lag_s(self) -> float:
        return self.values["damping"] / self.values["stiffness"]

    def __call__(self, frequencies_Hz: Floats) -> Complexes:
        form = with_valve if VALVE_NAMES[0] in self.values else _model
        return form(np.log(list(self.values.values())), 2.0 * pi * frequencies_Hz)


def fit_joint(response: FrequencyResponse, clamped_Hz: float | None = None, band_Hz: Sequence[float] = (0.0, 1e9)) -> JointFit:
    """Least squares on the logarithm (dB and phase alike), weighted by the response's certainty.

    `clamped_Hz`: where the link's antiresonance is expected; None: Eq 4 alone. LogError for fewer lines than parameters.
    """
    lines = believed_lines(response, band_Hz)
    names = (*NAMES, *(LINK_NAMES if clamped_Hz is not None else ()))
    enough_lines(lines, len(names), response)
    link = [] if clamped_Hz is None else [log(clamped_Hz), *np.log(LINK_START)]
    guesses = [np.array([*_joint_guess(_beside(lines, clamped_Hz), start), *link]) for start in STARTS]
    return best_fit(lines, names, _model, [(guess, _limits(guess)) for guess in guesses])


def best_fit(lines: Lines, names: Sequence[str], form: Form, starts: Sequence[tuple[Floats, tuple[Floats, Floats]]]) -> JointFit:
    """The one of several guesses, each with its limits, that leaves least."""
    return min((fitted(lines, names, form, *start) for start in starts), key=lambda one: one[1])[0]


def _beside(lines: Lines, clamped_Hz: float | None) -> Lines:
    """The lines that the link leaves alone; all where that is fewer than three."""
    if clamped_Hz is None:
        return lines
    away = np.abs(np.log(lines.omega / (2.0 * pi * clamped_Hz))) > log(BESIDE_LINK)
    return Lines(lines.omega[away], lines.measured[away], lines.sigma[away]) if np.count_nonzero(away) >= 3 else lines


def _joint_guess(lines: Lines, start: float) -> Floats:
    """Logarithms of gain, damping and stiffness: velocity gain and lag as the lowest lines have them."""
    natural = start * lags_half_a_turn(lines)
    low = slice(0, max(3, len(lines.omega) // 4))
    velocity = (1j * lines.omega * lines.measured)[low]
    lag_s = float(np.median(-np.angle(velocity) / lines.omega[low]))
    low_damping, high_damping = DAMPING
    damping = float(np.clip(0.5 * lag_s * natural, 2.0 * low_damping, 0.5 * high_damping))  # friction makes slow lines lead
    return np.log([float(np.median(np.abs(velocity))) * natural**2, 2.0 * damping * natural, natural**2])


def lags_half_a_turn(lines: Lines) -> float:
    """rad/s; the last line where the response never lags so much."""
    beyond = np.flatnonzero(np.unwrap(np.angle(lines.measured)) < -pi)
    return float(lines.omega[beyond[0] if len(beyond) else -1])


def fitted(lines: Lines, names: Sequence[str], form: Form, guess: Floats, limits: tuple[Floats, Floats]) -> tuple[JointFit, float]:
    """The fit of a form to lines from a guess of its logarithms, and what is left of the weighted squares."""
    weight = sqrt(2.0) / np.maximum(lines.sigma, LEAST_SIGMA)  # sigma is a complex value's: either part has 1/√2 of it

    def misfit(parameters: Floats) -> Floats:
        error = np.log(lines.measured / form(parameters, lines.omega))
        return np.concatenate([weight * error.real, weight * error.imag])

    best = least_squares(misfit, guess, bounds=limits, loss="soft_l1", f_scale=sqrt(2.0) * OUTLIER_SIGMAS)
    left = np.log(lines.measured / form(best.x, lines.omega))
    found = JointFit(
        dict(zip(names, np.exp(best.x).tolist(), strict=True)),
        _uncertainty(names, best.jac, misfit(best.x)),
        float(np.max(np.abs(left.real))) * 20.0 / log(10.0),
        degrees(float(np.max(np.abs(left.imag)))),
        tuple(name for name, on in zip(names, best.active_mask, strict=True) if on),
    )
    return found, float(best.cost)


class Lines(NamedTuple):
    """Frequency in rad/s, value and relative standard deviation."""

    omega: Floats
    measured: Complexes
    sigma: Floats


def enough_lines(lines: Lines, parameters: int, response: FrequencyResponse) -> None:
    """LogError for fewer lines than parameters."""
    if 2 * len(lines.omega) < parameters + 2:
        where = f"response of {response.source}"
        raise LogError("too few lines for the fit", value=len(lines.omega), limit=parameters // 2 + 2, where=where)


def believed_lines(response: FrequencyResponse, band_Hz: Sequence[float] = (0.0, 1e9)) -> Lines:
    """The lines in the band that are known well enough."""
    used = (response.frequencies_Hz >= band_Hz[0]) & (response.frequencies_Hz <= band_Hz[1]) & (response.sigma < LARGEST_SIGMA)
    return Lines(2.0 * pi * response.frequencies_Hz[used], response.response[used], response.sigma[used])


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
    gain, _, stiffness = guess[:3]
    twice_natural = log(2.0) + 0.5 * stiffness
    limits = [
        (gain - log(GAIN_FACTOR), gain + log(GAIN_FACTOR)),
        (twice_natural + log(DAMPING[0]), twice_natural + log(DAMPING[1])),
        (stiffness - log(STIFFNESS_FACTOR), stiffness + log(STIFFNESS_FACTOR)),
    ]
    if len(guess) > 3:
        limits += [(guess[3] + log(1.0 - ZERO_SHARE), guess[3] + log(1.0 + ZERO_SHARE)), *((log(a), log(b)) for a, b in LINK_LIMITS)]
    low, high = np.array(limits).T
    return low, high


def with_valve(parameters: Floats, omega: Floats) -> Complexes:
    """Eq 4's form behind a valve; the last two parameters are the valve's frequency (Hz) and damping ratio."""
    frequency_Hz, damping = np.exp(parameters[-2:])
    s = 1j * omega / (2.0 * pi * frequency_Hz)
    return np.asarray(_model(parameters[:-2], omega) / (1.0 + 2.0 * damping * s + s**2), dtype=np.complex128)


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
