"""Where model and measurement disagree: channel, balance equation, operating region, band. Reported even when no name is found.

The equation is the balance that comes out even least (weak form). Where the sensors do not allow a balance to be formed, it is that of
the effect that is named, if it is not one of those seen to hold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from config.schema.rig import Rig
from gap.balance.balances import Balance, balances
from gap.balance.dependence import dependences
from gap.data.measured import Array, Measured
from gap.data.noise import noise_floors
from gap.fitting.evaluation import Evaluation, mean_channel_costs
from gap.outcome.names import Named
from gap.outcome.spectrum_left import band, left_of
from sim_backend.kernel.parameters import Parameters

VIOLATED = 2.0  # standard deviations of the imbalance, root mean square over a log
LEAST_SHARE = 0.05  # of the excess, for a channel to be reported
BINS = 5
LEAST_IN_BIN = 50  # samples
_SMOOTHED = 9  # samples over which a velocity is averaged


@dataclass(frozen=True, slots=True)
class Region:
    """A range of an operating variable (SI) in which the excess is `times` its mean."""

    variable: str
    low: float
    high: float
    times: float

    def text(self) -> str:
        return f"{self.variable} from {self.low:.3g} to {self.high:.3g}: {self.times:.1f} times the mean"


@dataclass(frozen=True, slots=True)
class Disagreement:
    """One place of disagreement; `share` of the whole excess over the noise."""

    channel: str
    equation: str
    region: str
    band_Hz: tuple[float, float]
    share: float
    imbalance_z: float | None = None  # of the equation in standard deviations; None where it could not be formed
    over: Region | None = None  # the region where it is a range of one variable
    depends_on: tuple[dict[str, Any], ...] = ()  # on what the imbalance depends most, with means and 95 % intervals
    windows: tuple[dict[str, Any], ...] = ()  # parts of logs in which it is largest, where these are known

    def as_dict(self) -> dict[str, Any]:
        return asdict(self) | {"band_Hz": list(self.band_Hz)}


def localise(evaluations: Sequence[Evaluation], names: Sequence[str], named: Named | None, rig: Rig) -> list[Disagreement]:
    """The channels with most of the excess, largest first. `named`: the first name."""
    excess = np.maximum(mean_channel_costs(evaluations) - 1.05, 0.0)
    if excess.sum() <= 0.02:
        return []
    shares = excess / excess.sum()
    formed = formed_balances([e.experiment.log for e in evaluations], rig)
    worst = most_violated(formed)
    if worst is None:
        equation, z, found = _by_name(named, formed), None, []
    else:
        equation, z = f"{worst[1].equation} of {worst[1].where}", round(worst[1].z, 1)
        found = dependences(worst[1], worst[0], rig)
    depends_on = tuple(d.as_dict() for d in found)
    values = [operating_values(e, rig) for e in evaluations]
    places = []
    for k in np.argsort(-shares):
        if shares[k] >= LEAST_SHARE:
            over = None if found else most_in(evaluations, values, [left_of(e, k) ** 2 - 1.0 for e in evaluations])
            region = found[0].text() if found else over.text() if over else "everywhere"
            places.append(Disagreement(names[k], equation, region, band(evaluations, k), round(float(shares[k]), 3), z, over, depends_on))
    return places


def formed_balances(logs: Sequence[Measured], rig: Rig) -> list[tuple[Measured, Balance]]:
    """Every balance of every log, with its log."""
    sigma = noise_floors(logs, rig)
    return [(log, balance) for log in logs for balance in balances(log, rig, sigma)]


def most_violated(formed: Sequence[tuple[Measured, Balance]]) -> tuple[Measured, Balance] | None:
    """The balance that comes out even least, with its log; None where all come out even."""
    worst = max(formed, key=lambda item: item[1].z, default=None)
    return None if worst is None or worst[1].z < VIOLATED else worst


def _by_name(named: Named | None, formed: Sequence[tuple[Measured, Balance]]) -> str:
    """The equation of what is named; none that is seen to hold."""
    held = {(balance.equation, balance.where) for _, balance in formed}
    if named is None or not named.equation or (named.equation, named.suspect.where) in held:
        return "not located"
    return f"{named.equation} of {named.suspect.where}"


def operating_values(evaluation: Evaluation, rig: Rig) -> Mapping[str, Array]:
    """Velocity, command and position of every joint in each window, windows × samples."""
    experiment, slots = evaluation.experiment, Parameters(rig).slots
    rows = experiment.plan.starts[:, None] + experiment.plan.every * np.arange(experiment.plan.samples)[None, :]
    found: dict[str, Array] = {}
    for joint, slot in slots.items():
        position = experiment.log.channels[f"{joint}.position"].values[rows]
        slope = np.gradient(position, experiment.plan.every * experiment.log.period_s, axis=1)
        smooth = uniform_filter1d(np.nan_to_num(slope), min(_SMOOTHED, experiment.plan.samples), axis=1, mode="nearest")
        found |= {f"{joint}.velocity": smooth, f"{joint}.command_V": experiment.plan.commands_V[rows, slot], f"{joint}.position": position}
    return found


def most_in(evaluations: Sequence[Evaluation], values: Sequence[Mapping[str, Array]], excesses: Sequence[Array]) -> Region | None:
    """The fifth of an operating variable's range in which the excess is most concentrated; every window counts once, whatever its rate.
    None where it is no more than anywhere. `values` of the variables and `excesses` (NaN: not measured) log by log, windows × samples."""
    excess = np.concatenate([own.ravel() for own in excesses])
    weight = np.concatenate([np.full(own.size, 1.0 / e.experiment.plan.samples) for e, own in zip(evaluations, excesses, strict=True)])
    weight[~np.isfinite(excess)] = 0.0
    excess = np.nan_to_num(excess)
    mean = max(float(weight @ excess / weight.sum()), 1e-12)
    best: Region | None = None
    for name in values[0]:
        x = np.concatenate([v[name].ravel() for v in values])
        edges = np.unique(np.quantile(x[np.isfinite(x)], np.linspace(0, 1, BINS + 1)))
        for low, high in pairwise(edges):
            inside = (x >= low) & (x <= high) & (weight > 0.0)
            ratio = float(weight[inside] @ excess[inside] / weight[inside].sum() / mean) if inside.sum() > LEAST_IN_BIN else 0.0
            if ratio > (best.times if best else 1.0):
                best = Region(name, float(low), float(high), ratio)
    return best
