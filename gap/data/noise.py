"""Noise floor of every channel and how long its noise remembers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from config.schema.rig import Rig
from gap.data.data_check import quantum, same_maneuver
from gap.data.measured import Array, Measured

_SPAN = 21  # samples of the local fit
_ORDER = 3
_STRETCH_S = 0.4  # of two runs compared
_SAME_LENGTH_S = 0.5
_QUIET = 0.2  # quantile of the local variances: the windows in which least happens


def noise_floors(logs: Sequence[Measured], rig: Rig) -> dict[str, float]:
    """Standard deviation of each channel's noise, in the channel's unit.

    The larger of what the quietest stretches of the data show (residual of a local cubic), what the rig file declares (noise and
    resolution) and, where a maneuver was run more than once, what differs from run to run: coloured noise hides partly from a local
    fit, and no model predicts what the machine itself does not repeat. Never below q/√12.
    """
    names = dict.fromkeys(name for log in logs for name in log.channels)
    return {name: _floor(name, logs, rig) for name in names}


def _floor(name: str, logs: Sequence[Measured], rig: Rig) -> float:
    assert rig.plant is not None
    sensor = rig.plant.sensors[name]
    declared = sensor.noise**2 + sensor.resolution**2 / 12
    channels = [log.channels[name] for log in logs if name in log.channels]
    seen = np.concatenate([local_variances(channel.values) for channel in channels])
    quantised = max(quantum(channel) for channel in channels) ** 2 / 12
    shown = float(np.quantile(seen, _QUIET)) if seen.size else 0.0
    return float(np.sqrt(max(declared, shown, quantised, _repeated(name, logs))))


def _repeated(name: str, logs: Sequence[Measured]) -> float:
    """Half the variance of the difference of two runs of one maneuver, in stretches without their straight line; the median stretch, so
    that a late start of one motion does not count. 0 without repeats."""
    found = [
        np.median(_differences(a, b, name))
        for a, b in combinations([log for log in logs if name in log.channels], 2)
        if abs(a.rows - b.rows) * a.period_s < _SAME_LENGTH_S and abs(a.period_s / b.period_s - 1) < 1e-3 and same_maneuver(a, b)
    ]
    return float(np.median(found)) if found else 0.0


def _differences(a: Measured, b: Measured, name: str) -> Array:
    rows = min(a.rows, b.rows)
    length = max(round(_STRETCH_S / a.period_s), 8)
    count = rows // length
    difference = (a.channels[name].values[: count * length] - b.channels[name].values[: count * length]).reshape(count, length)
    whole = difference[np.all(np.isfinite(difference), axis=1)]
    basis = np.vander(np.linspace(-1, 1, length), 2)
    left = whole - (whole @ np.linalg.pinv(basis).T) @ basis.T
    return np.asarray(np.sum(left**2, axis=1) / (length - 2) / 2) if len(whole) else np.zeros(1)


def local_variances(values: Array) -> Array:
    """Variance of the residual of a cubic through every `_SPAN` samples (A. Savitzky and M. Golay, Analytical Chemistry 36, 1964)."""
    count = len(values) // _SPAN
    blocks = values[: count * _SPAN].reshape(count, _SPAN)
    blocks = blocks[np.all(np.isfinite(blocks), axis=1)]
    basis = np.vander(np.linspace(-1, 1, _SPAN), _ORDER + 1)
    projector = np.eye(_SPAN) - basis @ np.linalg.pinv(basis)
    return np.asarray(np.sum((blocks @ projector) ** 2, axis=1) / (_SPAN - _ORDER - 1))


def correlation_time(residuals: Array) -> float:
    """τ = 1 + 2 Σ ρ_k in samples, by the initial monotone sequence (C. Geyer, Statistical Science 7, 1992); residuals: windows × samples,
    NaN where nothing was measured.

    N / τ is the number of independent samples. 1 where nothing was measured.
    """
    data = np.nan_to_num(residuals - np.nanmean(residuals)) if np.isfinite(residuals).any() else np.zeros_like(residuals)
    length = data.shape[1]
    spectrum = np.abs(np.fft.rfft(data, 2 * length, axis=1)) ** 2
    sums = np.fft.irfft(spectrum, axis=1)[:, :length].sum(axis=0)
    if sums[0] <= 0:
        return 1.0
    rho = sums / sums[0] * length / np.arange(length, 0, -1)
    pairs = rho[0 : 2 * (length // 2) : 2] + rho[1 : 2 * (length // 2) : 2]
    negative = np.flatnonzero(pairs <= 0)
    end = int(negative[0]) if negative.size else len(pairs)
    return float(max(2 * np.minimum.accumulate(pairs[:end]).sum() - 1, 1.0)) if end else 1.0
