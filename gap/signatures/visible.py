"""The smallest size of every effect that a search on these logs would have named: found by simulation, because many effects are not
proportional to their size (a saturation above the largest opening used does nothing at all)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gap.fitting.evaluation import Costing
from gap.fitting.fit import Fit
from gap.fitting.model import Model
from gap.fitting.thinned import TO_SIZE, thinned
from gap.signatures.projection import ConstantsProjection, Probe, probed
from gap.signatures.screen import Screening, Signature, placed

ROUNDS = 3
CLOSE = 2.0  # ratio of energies within which a size is found
LARGEST_STEP = 30.0
LEAST_SHARE = 0.01  # of an effect's typical size: nothing smaller is claimed (a backlash makes the drive yield however small its gap)
_NOTHING = 1e-12  # of the energy wanted


def checked(screening: Screening, current: Fit, costs: Costing, seen_at: float) -> Screening:
    """The screening with sizes tried out, each with the probe closest to it; an effect that does not reach the energy `seen_at` within its
    plausible range has none."""
    current, share = thinned(current, TO_SIZE)
    projection, seen_at = ConstantsProjection(current, costs), share * seen_at
    known = {k: [s.probe] for k, s in enumerate(screening.signatures) if s.probe and scalable(s)}
    for _ in range(ROUNDS):
        todo = {k: _next(trials, seen_at) for k, trials in known.items() if not _found(trials, seen_at)}
        models = {k: model for k, size in todo.items() if (model := sized(screening.signatures[k], size)) is not None}
        if not models:
            break
        for k, probe in zip(models, probed(current, projection, list(models.values()), [todo[k] for k in models]), strict=True):
            known[k].append(probe)
    signatures = [
        _answered(s, known[k], seen_at) if k in known else s  # its first guess
        for k, s in enumerate(screening.signatures)
    ]
    return replace(screening, signatures=tuple(signatures))


def sized(signature: Signature, size: float) -> Model | None:
    """The probe's model with the first parameter this far from its neutral value; None outside the plausible range."""
    assert signature.probe is not None
    model, free = signature.probe.model, signature.candidate.free[0]
    values = model.theta[model.of_effect(model.added[-1])].copy()
    values[0] = free.start + np.sign(values[0] - free.start) * size
    return placed(model, [float(v) for v in values]) if free.low <= values[0] <= free.high else None


def scalable(signature: Signature) -> bool:
    """Whether a smaller value is a smaller effect; a link bends the more the smaller its stiffness."""
    return signature.candidate.smaller_is_weaker


def _found(trials: list[Probe], seen_at: float) -> bool:
    return any(1 / CLOSE < probe.energy / seen_at < CLOSE for probe in trials)


def _next(trials: list[Probe], seen_at: float) -> float:
    """The size to try: along the line through the two trials on a double logarithmic scale, first as if proportional."""
    last = trials[-1]
    if last.energy < _NOTHING * seen_at:
        return float(np.sqrt(last.size * trials[0].size))
    power = 2.0
    if len(trials) > 1 and trials[-2].size != last.size:
        power = float(np.log(max(last.energy, 1e-30) / max(trials[-2].energy, 1e-30)) / np.log(last.size / trials[-2].size))
    step = (seen_at / last.energy) ** (1.0 / min(max(power, 0.5), 20.0))
    return last.size * float(np.clip(step, 1 / LARGEST_STEP, LARGEST_STEP))


def _answered(signature: Signature, trials: list[Probe], seen_at: float) -> Signature:
    assert signature.candidate.free
    closest = min(trials, key=lambda probe: abs(np.log(max(probe.energy, 1e-30) / seen_at)))
    size = max(_interpolated(signature, trials, closest, seen_at), LEAST_SHARE * signature.candidate.free[0].scale)
    return replace(signature, smallest_visible=size, probe=closest)


def _interpolated(signature: Signature, trials: list[Probe], closest: Probe, seen_at: float) -> float:
    if 1 / CLOSE < closest.energy / seen_at < CLOSE:
        return closest.size * float(np.sqrt(seen_at / closest.energy))
    return _next(trials, seen_at) if sized(signature, _next(trials, seen_at)) is not None else np.inf
