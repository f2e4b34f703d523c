"""Search for a lag-lead compensator: the stiffest against disturbances that keeps its margins over a whole family of plants.

The stiffness a disturbance meets grows by |1 + L|, so the mean of ln|1 + L| over a band is maximised in the worst member, subject to
gain margin, phase margin and M_s in every member, and, for an arm, to the damping of every mode of the sampled closed loop.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import log

import numpy as np
from scipy.optimize import differential_evolution, minimize

from tuning.arrays import Complexes, Floats
from tuning.linear.closed_loop import Servo
from tuning.linear.family import compensator_response
from tuning.linear.margins import Margins, margins

PlantResponse = Callable[[Floats], Complexes]  # position per V, with all dead time, at frequencies in rad/s
GRID_HZ = (0.02, 60.0, 500)
SMOOTH_BANDS = 6
LESS_GAIN = 0.02


@dataclass(frozen=True, slots=True)
class Demands:
    """What every member must have, and the limits of the search: corners in rad/s, pole/zero of the lead, zero/pole of the lag."""

    gain_margin_dB: float = 6.0
    phase_margin_deg: float = 45.0
    sensitivity_peak: float = 1.7
    band_Hz: tuple[float, float] = (0.1, 5.4)
    lead_ratio: float = 10.0
    lag_ratio: float = 6.0
    lead_zero: tuple[float, float] = (10.0, 200.0)
    lag_zero: tuple[float, float] = (0.5, 8.0)


@dataclass(frozen=True, slots=True)
class Design:
    """`stiffness_gain_dB`: mean of |1 + L| over the band in the worst member. `worst`: smallest margins, largest peak and crossover."""

    servo: Servo
    stiffness_gain_dB: float
    worst: Margins
    least_damping: float | None


@dataclass(frozen=True, slots=True)
class DesignProblem:
    """Plants (position per V in the unit the gain is per), demands, and the damping that a servo must leave every mode.

    `pace`: how many times as fast as the paper's joint; the frequencies of the search move with it.
    """

    plants: tuple[PlantResponse, ...]
    demands: Demands = field(default_factory=Demands)
    tip_gain: float = 0.0
    roll_off_Hz: float = 15.0
    damping: Callable[[Servo], float] | None = None
    least_damping: float = 0.0
    pace: float = 1.0


def at_pace(pace: float) -> Demands:
    """The usual demands, band and corners moved to a joint that is so many times as fast as the paper's."""
    usual = Demands()

    def moved(limits: tuple[float, float]) -> tuple[float, float]:
        return pace * limits[0], pace * limits[1]

    return replace(usual, band_Hz=moved(usual.band_Hz), lead_zero=moved(usual.lead_zero), lag_zero=moved(usual.lag_zero))


def stiffness_gain_dB(problem: DesignProblem, servo: Servo) -> float:
    """Mean of 20 log10 |1 + L| over the band, evenly in log frequency, in the worst member."""
    low, high = problem.demands.band_Hz
    omega = 2.0 * np.pi * np.geomspace(low, high, 200)
    compensator = compensator_response(servo, omega)
    return min(float(np.mean(20.0 * np.log10(np.abs(1.0 + compensator * plant(omega))))) for plant in problem.plants)


def evaluate(problem: DesignProblem, servo: Servo) -> Design:
    """The figures of one servo."""
    found = [margins(_Loop(servo, plant), problem.pace) for plant in problem.plants]
    worst = Margins(
        max(m.crossover_Hz for m in found),
        min(m.phase_margin_deg for m in found),
        min(m.gain_margin_dB for m in found),
        max(m.sensitivity_peak for m in found),
    )
    damping = problem.damping(servo) if problem.damping else None
    return Design(servo, stiffness_gain_dB(problem, servo), worst, damping)


def search(problem: DesignProblem, *, with_sections: bool = True, seed: int = 1, effort: int = 60) -> Design:
    """The best lag-lead, or the best pure gain with `with_sections` False. `effort`: generations of the search."""
    grid = _Grid(problem)
    d = problem.demands
    limits = [(log(0.03), log(60.0))] if not with_sections else []
    if with_sections:
        limits = [(log(0.03), log(60.0)), _logs(d.lead_zero), (0.0, log(d.lead_ratio)), _logs(d.lag_zero), (0.0, log(d.lag_ratio))]
    limits[0] = (limits[0][0] + grid.log_scale, limits[0][1] + grid.log_scale)

    def cost(v: Floats) -> float:
        servo = _servo(v, problem)
        return -grid.stiffness(servo) - 30.0 * min(0.0, float(grid.slack(servo).min()))

    found = differential_evolution(cost, limits, seed=seed, maxiter=effort, popsize=12, tol=1e-8, polish=False)
    return evaluate(problem, _servo(_polished(grid, found.x, limits, problem), problem))


def _polished(grid: _Grid, start: Floats, limits: list[tuple[float, float]], problem: DesignProblem) -> Floats:
    """Refined along the boundary of the feasible region, where the best servo lies and a penalty only gets near."""

    def slack(v: Floats) -> Floats:
        return grid.slack(_servo(v, problem))

    def loss(v: Floats) -> float:
        return -grid.stiffness(_servo(v, problem))

    best = begin = start
    for _ in range(3):
        found = minimize(loss, begin, method="SLSQP", bounds=limits, constraints={"type": "ineq", "fun": slack}, options={"ftol": 1e-10})
        if slack(found.x).min() > -1e-6 and loss(found.x) <= loss(best):
            best = begin = found.x
        else:  # it diverged: once more from a little less gain, further inside the feasible region
            begin = begin - LESS_GAIN * (np.arange(len(begin)) == 0)
    return np.asarray(best, dtype=np.float64)


def _phase_at_crossover(log_gain: Floats, phase: Floats) -> float:
    """Smallest phase above −180° where a gain goes through 1, interpolated; both arrays are members × frequencies."""
    low, high = log_gain[:, :-1], log_gain[:, 1:]
    rows, columns = np.nonzero(low * high < 0.0)
    share = low[rows, columns] / (low[rows, columns] - high[rows, columns])
    return float(np.min(phase[rows, columns] * (1.0 - share) + phase[rows, columns + 1] * share, initial=180.0))


def _logs(limits: tuple[float, float]) -> tuple[float, float]:
    return log(limits[0]), log(limits[1])


def _servo(v: Floats, problem: DesignProblem) -> Servo:
    """From the logarithms of high-frequency gain (without lag), lead zero, lead ratio, lag zero, lag ratio."""
    values = [float(x) for x in np.exp(v)]
    if len(values) == 1:
        return Servo(values[0], (), problem.tip_gain, problem.roll_off_Hz)
    gain, lead_zero, lead, lag_zero, lag = values
    return Servo(gain * lag, ((lead_zero, lead_zero * lead), (lag_zero, lag_zero / lag)), problem.tip_gain, problem.roll_off_Hz)


@dataclass(frozen=True, slots=True)
class _Loop:
    servo: Servo
    plant: PlantResponse

    def __call__(self, omega: Floats) -> Complexes:
        return compensator_response(self.servo, omega) * self.plant(omega)


class _Grid:
    """Everything that does not depend on the servo, computed once on a frequency grid."""

    def __init__(self, problem: DesignProblem) -> None:
        self._problem = problem
        band = np.geomspace(*problem.demands.band_Hz, 60) * 2.0 * np.pi
        low, high, points = GRID_HZ
        self._omega = 2.0 * np.pi * problem.pace * np.geomspace(low, high, points)
        self._band = band
        self._plants = np.array([plant(self._omega) for plant in problem.plants])
        self._in_band = np.array([plant(band) for plant in problem.plants])
        # gain that would cross at about 1 Hz (times the pace): makes the limits of the search independent of the gain's unit
        self.log_scale = -log(float(np.abs(self._plants[0])[np.argmin(np.abs(self._omega - 2.0 * np.pi * problem.pace))]))

    def stiffness(self, servo: Servo) -> float:
        """Mean of ln |1 + L| over the band in the worst member."""
        return float(np.log(np.abs(1.0 + compensator_response(servo, self._band) * self._in_band)).mean(axis=1).min())

    def slack(self, servo: Servo) -> Floats:
        """Margin to every demand in the worst member; negative where the demand is missed."""
        d = self._problem.demands
        loops = compensator_response(servo, self._omega) * self._plants
        phase = np.degrees(np.unwrap(np.angle(loops), axis=1)) + 180.0
        phase_margin = _phase_at_crossover(np.log(np.abs(loops)), phase)
        beyond = float(np.where(phase <= 0.0, np.abs(loops), 0.0).max())
        distance = np.abs(1.0 + loops)
        bands = np.array_split(distance, SMOOTH_BANDS, axis=1)  # each has one smooth minimum, which the polish needs
        left = [
            *(np.concatenate([band.min(axis=1) for band in bands]) - 1.0 / d.sensitivity_peak),
            (phase_margin - d.phase_margin_deg) / 60.0,
            -np.log10(max(beyond, 1e-3)) - d.gain_margin_dB / 20.0,
        ]
        if self._problem.damping is not None:
            left.append(10.0 * (self._problem.damping(servo) - self._problem.least_damping))
        return np.array(left)
