"""The smallest size of every effect that a search on these logs would have named: found by simulation, because many effects are not
proportional to their size (a saturation above the largest opening used does nothing at all)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gap.evaluation import Costing
from gap.fit import Fit
from gap.model import Model
from gap.screen import Remover, Screening, Signature, placed, rows
from gap.thinned import thinned

ROUNDS = 3
CLOSE = 2.0  # ratio of energies within which a size is found
LARGEST_STEP = 30.0
LEAST_SHARE = 0.01  # of an effect's typical size: nothing smaller is claimed (a backlash makes the drive yield however small its gap)
_NOTHING = 1e-12  # of the energy wanted


def checked(screening: Screening, current: Fit, costs: Costing, seen_at: float) -> Screening:
    """The screening with sizes tried out; an effect that does not reach the energy `seen_at` within its plausible range has none."""
    current, share = thinned(current)
    remover, seen_at = Remover(current, costs), share * seen_at
    known = {k: [s.probe[1:]] for k, s in enumerate(screening.signatures) if s.probe and _scalable(s)}
    for _ in range(ROUNDS):
        todo = {k: _next(trials, seen_at) for k, trials in known.items() if not _found(trials, seen_at)}
        todo = {k: size for k, size in todo.items() if _sized(screening.signatures[k], size) is not None}
        if not todo:
            break
        models = [model for k, size in todo.items() if (model := _sized(screening.signatures[k], size)) is not None]
        energies = np.sum(remover.remove(rows(current, remover, models)) ** 2, axis=1)
        for (k, size), energy in zip(todo.items(), energies, strict=True):
            known[k].append((size, float(energy)))
    sizes = {k: _answer(screening.signatures[k], trials, seen_at) for k, trials in known.items()}
    signatures = tuple(replace(s, smallest_visible=sizes.get(k, s.smallest_visible)) for k, s in enumerate(screening.signatures))
    return replace(screening, signatures=signatures)


def _scalable(signature: Signature) -> bool:
    """Whether a smaller value is a smaller effect; a link bends the more the smaller its stiffness."""
    return signature.candidate.effect != "link_flexibility"


def _found(trials: list[tuple[float, float]], seen_at: float) -> bool:
    return any(1 / CLOSE < energy / seen_at < CLOSE for _, energy in trials)


def _next(trials: list[tuple[float, float]], seen_at: float) -> float:
    """The size to try: along the line through the two trials on a double logarithmic scale, first as if proportional."""
    size, energy = trials[-1]
    if energy < _NOTHING * seen_at:
        return float(np.sqrt(size * trials[0][0]))
    power = 2.0
    if len(trials) > 1:
        (a, e), (b, f) = trials[-2], trials[-1]
        power = float(np.log(max(f, 1e-30) / max(e, 1e-30)) / np.log(b / a)) if a != b else 2.0
    step = (seen_at / energy) ** (1.0 / min(max(power, 0.5), 20.0))
    return size * float(np.clip(step, 1 / LARGEST_STEP, LARGEST_STEP))


def _sized(signature: Signature, size: float) -> Model | None:
    """The probe's model with the first parameter this far from its neutral value; None outside the plausible range."""
    assert signature.probe is not None
    model, free = signature.probe[0], signature.candidate.free[0]
    values = model.theta[model.of_effect(model.added[-1])].copy()
    values[0] = free.start + np.sign(values[0] - free.start) * size
    return placed(model, [float(v) for v in values]) if free.low <= values[0] <= free.high else None


def _answer(signature: Signature, trials: list[tuple[float, float]], seen_at: float) -> float:
    assert signature.candidate.free
    return max(_interpolated(signature, trials, seen_at), LEAST_SHARE * signature.candidate.free[0].scale)


def _interpolated(signature: Signature, trials: list[tuple[float, float]], seen_at: float) -> float:
    size, energy = min(trials, key=lambda item: abs(np.log(max(item[1], 1e-30) / seen_at)))
    if 1 / CLOSE < energy / seen_at < CLOSE:
        return size * float(np.sqrt(seen_at / energy))
    return _next(trials, seen_at) if _sized(signature, _next(trials, seen_at)) is not None else np.inf
