"""How much the tip still vibrates after a move: the figure by which shapers are compared.

Amplitude of the tip's acceleration 1.0 s after the planned end of every move, from a least-squares fit of a decaying sine (and a
constant) over three of its periods. The frequency starts at the link's own at the extension of the hold and is refined by the fit,
because the servo makes the real one a little lower.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import log10, pi, sqrt

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar

from config.errors import LogError
from config.schema.rig import LinkMode, Rig
from recording.files.reader import Log, open_rig
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode

AFTER_MOVE_S = 1.0
PERIODS = 3.0  # length of the window
FREQUENCY_SHARE = 0.15  # how far the fit may move the frequency
_NEEDED_SHARE = 0.6  # of the window that must lie inside the hold
APPROACH = "approach"  # the slow move to a program's start, which is no part of the program
TIP = "tip.acceleration_mps2"

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class HoldVibration:
    """One hold. `amplitude_mps2` is the peak of the sine at the moment 1.0 s after the move's end."""

    run: int
    move: str
    end_t_s: float
    frequency_Hz: float
    amplitude_mps2: float


def hold_vibration(log: Log) -> list[HoldVibration]:
    """Every move of every run's program that is followed by a hold long enough, in the order of time.

    Raises LogError when the log has no tip acceleration, no flexible link or no such move.
    """
    rig = open_rig(log)
    if rig.link_mode is None or np.all(np.isnan(log.columns.get(TIP, np.array([np.nan])))):
        advice = "The rig file needs link_mode, and the tip an accelerometer."
        raise LogError("the log says nothing about tip vibration", where=str(log.path), next_step=advice)
    runs = [int(n) for n in np.unique(log.columns["maneuver"]) if n and f"run-{n}.json" in log.attachments]
    found = [hold for run in runs for hold in _holds_of_run(log, rig, rig.link_mode, run)]
    if not found:
        advice = f"A move must be followed by a hold of more than {AFTER_MOVE_S} s."
        raise LogError("the log has no hold after a move", where=str(log.path), next_step=advice)
    return found


def decibels(shaped: Sequence[HoldVibration], unshaped: Sequence[HoldVibration]) -> list[float]:
    """20 log10 of the amplitude of every hold over that of the same hold in an unshaped run. ValueError when the runs differ."""
    return [20.0 * log10(hold.amplitude_mps2 / base.amplitude_mps2) for hold, base in zip(shaped, unshaped, strict=True)]


def rms_mps2(holds: Sequence[HoldVibration]) -> float:
    """Root mean square over the holds of a run."""
    return sqrt(sum(hold.amplitude_mps2**2 for hold in holds) / len(holds))


def decaying_sine(t: Floats, values: Floats, frequency_Hz: float, damping_ratio: float) -> tuple[float, float]:
    """(amplitude at t = 0, frequency) of the best fit to `values`; the frequency is searched within 15 %."""

    def residual(frequency: float) -> float:
        return float(np.sum((values - _basis(t, frequency, damping_ratio) @ _coefficients(t, values, frequency, damping_ratio)) ** 2))

    bounds = ((1 - FREQUENCY_SHARE) * frequency_Hz, (1 + FREQUENCY_SHARE) * frequency_Hz)
    best = float(minimize_scalar(residual, bounds=bounds, method="bounded", options={"xatol": 1e-4 * frequency_Hz}).x)
    cosine, sine, _ = _coefficients(t, values, best, damping_ratio)
    return float(np.hypot(cosine, sine)), best


def window_s(hold_s: float, frequency_Hz: float) -> tuple[float, float] | None:
    """Where in a hold of this length its vibration is judged (s after the move's end): three periods about 1.0 s, as far as they lie in
    the hold. None where the hold ends before 1.0 s, or holds too little of them."""
    half_s = 0.5 * PERIODS / frequency_Hz
    first_s, last_s = max(0.0, AFTER_MOVE_S - half_s), min(hold_s, AFTER_MOVE_S + half_s)
    return (first_s, last_s) if hold_s >= AFTER_MOVE_S and last_s - first_s >= _NEEDED_SHARE * 2.0 * half_s else None


def _holds_of_run(log: Log, rig: Rig, link: LinkMode, run: int) -> list[HoldVibration]:
    request = RunRequest.from_json(log.attachments[f"run-{run}.json"])
    if request.by_hand:
        return []
    segments = plan_run(rig, request).segments
    running = (log.columns["maneuver"] == run) & (log.columns["mode"] == Mode.RUNNING)
    found = []
    for number, (move, after) in enumerate(pairwise(segments), start=2):  # `after` has number index + 1
        rows = np.flatnonzero(running & (log.columns["segment"] == number))
        if move.kind == "move" and move.name != APPROACH and after.kind == "hold" and len(rows):
            found.append(_measure(log, link, run, move.name, rows))
    return [hold for hold in found if hold is not None]


def _measure(log: Log, link: LinkMode, run: int, name: str, rows: npt.NDArray[np.intp]) -> HoldVibration | None:
    """The vibration in the hold that has these rows; None when the hold ends before the window does."""
    frequency_Hz = LinkFrequency(link).frequency_Hz(_extension_m(log, rows))
    end_t_s = float(log.columns["t_s"][rows[0]])
    since_s, values = log.columns["t_s"][rows] - end_t_s, log.columns[TIP][rows]
    window = window_s(float(since_s[-1]), frequency_Hz)
    if window is None:
        return None
    inside = (since_s >= window[0]) & (since_s <= window[1]) & np.isfinite(values)
    if not inside.any() or np.ptp(since_s[inside]) < _NEEDED_SHARE * PERIODS / frequency_Hz:
        return None  # samples are lost
    amplitude, frequency = decaying_sine(since_s[inside] - AFTER_MOVE_S, values[inside], frequency_Hz, link.damping_ratio)
    return HoldVibration(run, name, end_t_s, frequency, amplitude)


def _extension_m(log: Log, rows: npt.NDArray[np.intp]) -> float:
    """Mean extension of the link in these rows: the linear joint's position."""
    if "prismatic.position" not in log.columns:
        raise LogError("the log has no joint `prismatic`, which sets the link's frequency", where=str(log.path))
    return float(np.nanmean(log.columns["prismatic.position"][rows]))


def _basis(t: Floats, frequency_Hz: float, damping_ratio: float) -> Floats:
    angle = 2.0 * pi * frequency_Hz * t
    decay = np.exp(-damping_ratio * angle)
    return np.column_stack([decay * np.cos(angle), decay * np.sin(angle), np.ones_like(t)])


def _coefficients(t: Floats, values: Floats, frequency_Hz: float, damping_ratio: float) -> Floats:
    return np.asarray(np.linalg.lstsq(_basis(t, frequency_Hz, damping_ratio), values, rcond=None)[0], dtype=np.float64)
