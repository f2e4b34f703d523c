"""Where in the motion it is that something else acts: channels, ranges and windows in which the discrepancy of a fitted set concentrates.

It is what the chosen set, fitted to all logs, leaves beyond what honest models leave: of a window whose discrepancy is δ s (in noise) the
part δ²s² / (1 + δ²s²) of the residual's power is no noise. A stick or a slip too early begins at a reversal, so time since the last one is
a variable as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from config.schema.rig import Rig
from gap.data.measured import Array
from gap.evidence.noise.noise_model import Discrepancy
from gap.fitting.evaluation import Evaluation
from gap.outcome.localise import LEAST_SHARE, Disagreement, formed_balances, most_in, most_violated, operating_values
from gap.outcome.spectrum_left import band, left_of
from sim_backend.kernel.parameters import Parameters

MOST_WINDOWS = 3  # named of a channel
TIMES = 2.0  # a window is named whose discrepancy has so many times the mean power
_AVERAGED = 9  # samples over which a velocity is averaged
_MOVING = 0.02  # of a joint's largest speed, below which a change of sign is no reversal


def where_unexplained(
    evaluations: Sequence[Evaluation], discrepancy: Discrepancy, beyond: Array, names: Sequence[str], rig: Rig
) -> list[Disagreement]:
    """Places, those with the largest share of the discrepancy first. `evaluations`: of the chosen set on all logs, in the windows that
    the discrepancy is of. `beyond`: of every channel, not 0 where more is left than honest models leave."""
    powers = [discrepancy.of_log(n) ** 2 * np.ones((len(e.experiment.measured), 1)) for n, e in enumerate(evaluations)]
    means = np.array([_mean(evaluations, powers, k) for k in range(len(names))]) * (beyond > 0.0)
    if means.sum() <= 0.0:
        return []
    worst = most_violated(formed_balances([e.experiment.log for e in evaluations], rig))
    equation, z = (f"{worst[1].equation} of {worst[1].where}", round(worst[1].z, 1)) if worst else ("not located", None)
    values = _in_all([{**operating_values(e, rig), **since_reversal(e, rig)} for e in evaluations])
    shares, places = means / means.sum(), []
    for k in np.argsort(-shares):
        if shares[k] >= LEAST_SHARE:
            parts = [p[:, k : k + 1] / (1.0 + p[:, k : k + 1]) * left_of(e, k) ** 2 for e, p in zip(evaluations, powers, strict=True)]
            over = most_in(evaluations, values, parts)
            region, windows = over.text() if over else "everywhere", _windows(evaluations, powers, int(k))
            share = round(float(shares[k]), 3)
            places.append(Disagreement(names[k], equation, region, band(evaluations, int(k)), share, z, over, (), windows))
    return places


def _in_all(values: Sequence[Mapping[str, Array]]) -> list[dict[str, Array]]:
    """Without a variable that a log lacks: nothing turns back in it."""
    shared = set.intersection(*(set(own) for own in values))
    return [{name: own[name] for name in own if name in shared} for own in values]


def since_reversal(evaluation: Evaluation, rig: Rig) -> Mapping[str, Array]:
    """Time since every joint last began to move the other way, windows × samples; NaN before the log's first reversal."""
    experiment, found = evaluation.experiment, {}
    log = experiment.log
    for joint in Parameters(rig).slots:
        position = log.channels[f"{joint}.position"].values
        there = np.flatnonzero(np.isfinite(position))
        velocity = uniform_filter1d(np.gradient(position[there], log.t_s[there]), _AVERAGED * experiment.plan.every, mode="nearest")
        turned = log.t_s[there][_turns(velocity)]
        last = np.searchsorted(turned, experiment.times_s, side="right") - 1
        if (last >= 0).any():
            found[f"{joint}.since_reversal_s"] = np.where(last >= 0, experiment.times_s - turned[np.maximum(last, 0)], np.nan)
    return found


def _turns(velocity: Array) -> NDArray[np.bool_]:
    """Samples at which a joint has begun to move the other way; slow motion keeps the sign it had."""
    moving = np.abs(velocity) > _MOVING * np.abs(velocity).max(initial=0.0)
    number = np.maximum.accumulate(np.where(moving, np.arange(len(velocity)), 0))
    sign = np.sign(velocity[number])
    return np.concatenate([[False], sign[1:] * sign[:-1] < 0.0])


def _mean(evaluations: Sequence[Evaluation], powers: Sequence[Array], k: int) -> float:
    """Of δ²s² over the windows in which the channel was measured."""
    there = [p[_measured(e, k), k] for e, p in zip(evaluations, powers, strict=True)]
    every = np.concatenate(there)
    return float(every.mean()) if every.size else 0.0


def _windows(evaluations: Sequence[Evaluation], powers: Sequence[Array], k: int) -> tuple[dict[str, Any], ...]:
    """Those with by far the largest discrepancy, as parts of their logs."""
    mean = _mean(evaluations, powers, k)
    found: list[dict[str, Any]] = []
    for e, power in zip(evaluations, powers, strict=True):
        times = e.experiment.times_s
        for w in np.flatnonzero(_measured(e, k) & (power[:, k] > TIMES * mean)):
            span = {"from_s": round(float(times[w, 0]), 3), "to_s": round(float(times[w, -1]), 3)}
            found.append({"file": e.experiment.log.path.name, **span, "times": round(float(power[w, k] / mean), 1)})
    return tuple(sorted(found, key=lambda one: -float(one["times"]))[:MOST_WINDOWS])


def _measured(evaluation: Evaluation, k: int) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(evaluation.experiment.measured[:, :, k]).any(axis=1))


def in_words(places: Sequence[Disagreement]) -> str:
    """The first place for the verdict; empty for none."""
    if not places:
        return ""
    first = places[0]
    spans = ", ".join(f"{w['from_s']:g} to {w['to_s']:g} s of {w['file']} ({w['times']:g} times)" for w in first.windows)
    return f" Most of it is in {first.channel}, {first.region}" + (f"; in the windows {spans}." if spans else ".")
