"""Amplitude spectrum of a record."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def hann_spectrum(values: Floats, period_s: float) -> tuple[Floats, Floats]:
    """(frequencies in Hz, one-sided amplitudes in the unit of `values`) of the whole record under a Hann window.

    A sine of amplitude A at a line of the spectrum shows as A. The mean is taken out first. No gaps allowed: see without_gaps.
    """
    window = np.hanning(len(values))
    lines = np.fft.rfft((values - np.mean(values)) * window)
    return np.asarray(np.fft.rfftfreq(len(values), period_s), dtype=np.float64), 2.0 * np.abs(lines) / np.sum(window)


def without_gaps(values: Floats) -> Floats:
    """NaN (lost samples) replaced by straight lines between their neighbours."""
    good = np.isfinite(values)
    if good.all():
        return values
    rows = np.arange(len(values))
    return np.interp(rows, rows[good], values[good])
