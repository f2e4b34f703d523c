"""Faults of the data that only show beside a simulation: swapped channels, wrong units, a reversed or late sensor.

Sign and delay of a sensor are effects the search can name, so they are warnings here. Swapped channels and units are no physics: they end
the search with the verdict data_problem.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gap.data.channel_check import DataProblem
from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation

# Unit for unit: what a channel in the wrong unit is multiplied by.
FACTORS = {
    "degrees for radians": 57.29578,
    "radians for degrees": 1 / 57.29578,
    "millimetres for metres": 1e3,
    "metres for millimetres": 1e-3,
    "inches for metres": 39.37008,
    "metres for inches": 0.0254,
    "psi for pascals": 1 / 6894.757,
    "pascals for psi": 6894.757,
    "bar for pascals": 1e-5,
    "pascals for bar": 1e5,
    "megapascals for pascals": 1e-6,
    "g for m/s²": 1 / 9.80665,
    "m/s² for g": 9.80665,
}
CLOSE = 0.08  # relative, of a slope to such a factor
LEAST_CORRELATION = 0.8  # correlation of measured and simulated changes
SWAPPED = 0.25  # share of the cost that is left when two channels change places
LARGEST_LAG_S = 0.1
LEAST_LAG_ROWS = 1.5  # samples compared
LEAST_LAG_GAIN = 0.05  # of the correlation


def against_model(evaluations: Sequence[Evaluation], names: Sequence[str]) -> list[DataProblem]:
    """Problems of every channel that moves in the simulation; `names`: of the compared channels."""
    found: list[DataProblem] = []
    for evaluation in evaluations:
        changes = [_changes(evaluation, k) for k in range(len(names))]
        for name, (measured, simulated) in zip(names, changes, strict=True):
            if measured.size and np.std(measured) > 0 and np.std(simulated) > 0:
                found += _one(evaluation, name, measured, simulated)
        found += _swaps(evaluation, names)
    return found


def _changes(evaluation: Evaluation, k: int) -> tuple[Array, Array]:
    """Measured and simulated values of whole windows, each without its window's mean (windows × samples)."""
    measured, simulated = evaluation.experiment.measured[:, :, k], evaluation.readings[:, :, k]
    whole = np.isfinite(measured).all(axis=1) & np.isfinite(simulated).all(axis=1)
    measured, simulated = measured[whole], simulated[whole]
    centred = [values - values.mean(axis=1, keepdims=True) for values in (measured, simulated)] if whole.any() else [measured, simulated]
    return centred[0], centred[1]


def _one(evaluation: Evaluation, name: str, measured: Array, simulated: Array) -> Iterator[DataProblem]:
    """Unit, sign and lag of one channel."""
    path, t_s = str(evaluation.experiment.log.path), evaluation.experiment.log.t_s
    span = f"from t = {t_s[0]:.3f} to {t_s[-1]:.3f} s"
    correlation = float(np.sum(measured * simulated) / np.sqrt(np.sum(measured**2) * np.sum(simulated**2)))
    slope = float(np.sum(measured * simulated) / np.sum(simulated**2))
    unit = next((word for word, factor in FACTORS.items() if abs(abs(slope) / factor - 1) < CLOSE), None)
    if abs(correlation) > LEAST_CORRELATION and unit:
        what = f"its changes are {abs(slope):.4g} times what the plant predicts, {span}: {unit}?"
        yield DataProblem(what, name, path, True)
    elif correlation < -LEAST_CORRELATION:
        yield DataProblem(f"moves against the simulation (correlation {correlation:.2f}), {span}: sign of the sensor", name, path, False)
    elif (lag_s := _lag(evaluation, measured, simulated)) is not None:
        late = f"{1e3 * abs(lag_s):.3g} ms {'late' if lag_s > 0 else 'early'}"
        yield DataProblem(f"is {late} against the simulation, {span}", name, path, False)


def _lag(evaluation: Evaluation, measured: Array, simulated: Array) -> float | None:
    """Shift (s, positive: measured late) at which the correlation is clearly best, refined between samples by a parabola."""
    step_s = evaluation.experiment.plan.every * evaluation.experiment.log.period_s
    most = min(round(LARGEST_LAG_S / step_s), measured.shape[1] // 3)
    shifts = np.arange(-most, most + 1)
    curve = np.array([_at(measured, simulated, int(shift)) for shift in shifts])
    best = int(np.argmax(curve))
    if not 0 < best < len(curve) - 1 or curve[best] < LEAST_CORRELATION or curve[best] < curve[most] + LEAST_LAG_GAIN:
        return None
    bend = curve[best - 1] - 2 * curve[best] + curve[best + 1]
    shift = shifts[best] + 0.5 * (curve[best - 1] - curve[best + 1]) / bend
    return float(shift * step_s) if abs(shift) >= LEAST_LAG_ROWS else None


def _at(measured: Array, simulated: Array, shift: int) -> float:
    """Correlation of measured with the simulation `shift` samples earlier, over the part of the windows both have."""
    a, b = (measured[:, shift:], simulated[:, : simulated.shape[1] - shift]) if shift >= 0 else (measured[:, :shift], simulated[:, -shift:])
    a, b = a - a.mean(axis=1, keepdims=True), b - b.mean(axis=1, keepdims=True)
    size = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b)) / size if size > 0 else 0.0


def _swaps(evaluation: Evaluation, names: Sequence[str]) -> Iterator[DataProblem]:
    """Chamber pressures that fit the simulation far better when they change places."""
    experiment = evaluation.experiment
    for name in names:
        other = name.removesuffix("_a") + "_b"
        if not name.endswith(".pressure_a") or other not in names:
            continue
        k = [names.index(name), names.index(other)]
        measured, simulated, sigma = experiment.measured[:, :, k], evaluation.readings[:, :, k], experiment.sigma[k]
        straight, crossed = (float(np.nanmean(((measured - r) / sigma) ** 2)) for r in (simulated, simulated[:, :, ::-1]))
        if straight > 10 and crossed < SWAPPED * straight:
            t_s = experiment.log.t_s
            what = f"fits the simulation of {other} and the other way round, t = {t_s[0]:.3f} to {t_s[-1]:.3f} s: swapped channels"
            yield DataProblem(what, name, str(experiment.log.path), True)
