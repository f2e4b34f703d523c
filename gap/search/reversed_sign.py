"""A model in which a tip cannot move reads 0 whatever the sign of its sensor: what moves it is tried with the sign reversed, too."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from config.schema.effect import Equation
from gap.fitting.fit import Fit
from gap.search.trial import Base, Trial, first_trial, own_trial
from gap.signatures.candidates import Candidate, candidates
from gap.signatures.screen import points


def reversed_trials(base: Base, kept: Sequence[Candidate], channels: frozenset[str], others: Sequence[Fit]) -> Iterator[Trial]:
    """Every candidate that bends the link, beside the reversed sign of every sensor of which the present model predicts nothing."""
    rig = base.current.model.rig
    bending = [candidate for candidate in kept if candidate.equation == Equation.LINK]
    for polarity in candidates(rig, channels) if bending else ():
        if polarity.effect != "sensor_polarity" or not _silent(base, polarity.where.removeprefix("sensor:")):
            continue
        current, *nominal = (replace(f, model=f.model.with_effect(polarity.entry, ())) for f in (base.current, *others))
        reversed_ = replace(base, current=current)
        for candidate in bending:
            trial = first_trial(reversed_, candidate, points(candidate, current.model))
            yield replace(own_trial(reversed_, trial, nominal), beside=polarity)


def _silent(base: Base, signal: str) -> bool:
    """Whether the present model predicts that a sensor reads 0 all the time."""
    plant = base.current.model.rig.plant
    number = list(plant.sensors).index(signal) if plant else -1
    parts = [(e.readings[:, :, k], e.experiment.sigma[k]) for e in base.seen for k, n in enumerate(e.experiment.columns) if n == number]
    return bool(parts) and all(np.abs(readings).max() < sigma for readings, sigma in parts)
