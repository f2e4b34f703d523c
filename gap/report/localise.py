"""Where model and measurement disagree: channel, balance equation, operating region, band. Reported even when no name is found.

The equation is the balance that comes out even least (weak form). Where the sensors do not allow a balance to be formed, it is the
one whose effects leave the best signature, among those not seen to hold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from config.rig import Rig
from gap.balance.balances import Balance, balances
from gap.balance.dependence import dependences
from gap.data.measured import Array, Measured
from gap.data.noise import noise_floors
from gap.fitting.evaluation import Evaluation
from gap.search.screen import Screening
from sim_backend.parameters import Parameters

VIOLATED = 2.0  # standard deviations of the imbalance, root mean square over a log
LEAST_SHARE = 0.05  # of the excess, for a channel to be reported
BINS = 5
_BAND = (0.05, 0.95)  # cumulated excess between which the band lies


@dataclass(frozen=True, slots=True)
class Place:
    """One place of disagreement; `share` of the whole excess over the noise."""

    channel: str
    equation: str
    region: str
    band_Hz: tuple[float, float]
    share: float
    imbalance_z: float | None = None  # of the equation in standard deviations; None where it could not be formed
    depends_on: tuple[dict[str, Any], ...] = ()  # on what the imbalance depends most, with means and 95 % intervals

    def as_dict(self) -> dict[str, Any]:
        return asdict(self) | {"band_Hz": list(self.band_Hz)}


def localise(evaluations: Sequence[Evaluation], names: Sequence[str], screening: Screening | None, rig: Rig) -> list[Place]:
    """The channels with most of the excess, largest first."""
    excess = np.maximum(np.mean([e.channel_costs for e in evaluations], axis=0) - 1.05, 0.0)
    if excess.sum() <= 0.02:
        return []
    shares = excess / excess.sum()
    formed = _formed([e.experiment.log for e in evaluations], rig)
    worst = max(formed, key=lambda item: item[1].z, default=None)
    if worst is None or worst[1].z < VIOLATED:
        equation, z, found = _by_signature(screening, formed), None, []
    else:
        equation, z = f"{worst[1].equation} of {worst[1].where}", round(worst[1].z, 1)
        found = dependences(worst[1], worst[0], rig)
    depends_on = tuple(d.as_dict() for d in found)
    return [
        Place(
            names[k],
            equation,
            found[0].text() if found else _region(evaluations, k, rig),
            _band(evaluations, k),
            round(float(shares[k]), 3),
            z,
            depends_on,
        )
        for k in np.argsort(-shares)
        if shares[k] >= LEAST_SHARE
    ]


def _formed(logs: Sequence[Measured], rig: Rig) -> list[tuple[Measured, Balance]]:
    """Every balance of every log, with its log."""
    sigma = noise_floors(logs, rig)
    return [(log, balance) for log in logs for balance in balances(log, rig, sigma)]


def _by_signature(screening: Screening | None, formed: Sequence[tuple[Measured, Balance]]) -> str:
    """The equation whose effects explain most of the residual, freed of what the constants explain; none of those seen to hold."""
    held = {(balance.equation, balance.where) for _, balance in formed}
    shares = {key: share for key, share in (screening.shares_by_equation() if screening else {}).items() if key not in held}
    if not shares:
        return "not located"
    (equation, where), share = max(shares.items(), key=lambda item: item[1])
    return f"{equation} of {where}" if share > 0.05 else "not located"


def _samples(evaluation: Evaluation, k: int) -> Array:
    """What is left of one channel in noise units, windows × samples."""
    left = evaluation.left[:, : evaluation.experiment.measured[0].size]
    return left.reshape(evaluation.experiment.measured.shape)[:, :, k]


def operating_values(evaluation: Evaluation, rig: Rig) -> Mapping[str, Array]:
    """Velocity, command and position of every joint in each window, windows × samples."""
    experiment, slots = evaluation.experiment, Parameters(rig).slots
    rows = experiment.plan.starts[:, None] + experiment.plan.every * np.arange(experiment.plan.samples)[None, :]
    found: dict[str, Array] = {}
    for joint, slot in slots.items():
        position = experiment.log.channels[f"{joint}.position"].values[rows]
        slope = np.gradient(position, experiment.plan.every * experiment.log.period_s, axis=1)
        smooth = np.apply_along_axis(lambda v: np.convolve(v, np.ones(9) / 9, mode="same"), 1, np.nan_to_num(slope))
        found |= {f"{joint}.velocity": smooth, f"{joint}.command_V": experiment.plan.commands_V[rows, slot], f"{joint}.position": position}
    return found


def _region(evaluations: Sequence[Evaluation], k: int, rig: Rig) -> str:
    """The fifth of an operating variable's range in which the excess is most concentrated."""
    squares = np.concatenate([_samples(e, k).ravel() ** 2 for e in evaluations]) - 1
    values = [operating_values(e, rig) for e in evaluations]
    best, text = 1.0, "everywhere"
    for name in values[0]:
        x = np.concatenate([v[name].ravel() for v in values])
        edges = np.unique(np.quantile(x[np.isfinite(x)], np.linspace(0, 1, BINS + 1)))
        for low, high in pairwise(edges):
            inside = (x >= low) & (x <= high)
            ratio = float(squares[inside].mean() / max(squares.mean(), 1e-12)) if inside.sum() > 50 else 0.0
            if ratio > best:
                best, text = ratio, f"{name} from {low:.3g} to {high:.3g}: {ratio:.1f} times the mean"
    return text


def _band(evaluations: Sequence[Evaluation], k: int) -> tuple[float, float]:
    frequency, density = spectrum(evaluations, k)
    excess = np.cumsum(np.maximum(density - 1.0, 0.0))
    if excess.size == 0 or excess[-1] <= 0:
        return (0.0, 0.0)
    low, high = (int(np.searchsorted(excess / excess[-1], level)) for level in _BAND)
    return (round(float(frequency[low]), 2), round(float(frequency[min(high, len(frequency) - 1)]), 2))


def spectrum(evaluations: Sequence[Evaluation], k: int) -> tuple[Array, Array]:
    """Frequencies (Hz) and mean power of what is left in a channel over that of white noise at its floor."""
    experiment = evaluations[0].experiment
    length = experiment.plan.samples
    taper = np.hanning(length)
    powers = [np.abs(np.fft.rfft(np.nan_to_num(_samples(e, k)) * taper, axis=1)) ** 2 for e in evaluations]
    density = np.concatenate(powers).mean(axis=0) / np.sum(taper**2)
    frequency = np.fft.rfftfreq(length, experiment.plan.every * experiment.log.period_s)
    return np.asarray(frequency[1:], dtype=np.float64), np.asarray(density[1:], dtype=np.float64)
