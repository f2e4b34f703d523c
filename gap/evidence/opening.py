"""From logs cut into windows to the search before its first stage: the rig file as it is, beside what it can be expected to leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from config.schema.rig import Rig
from gap.data.measured import Array
from gap.data.strata import chosen
from gap.data.windows import Experiment, velocities
from gap.evidence.deciding_numbers import EXPECTED, HONEST, LEAST_DISCREPANCY, MEMORY_S, OTHER_FORM
from gap.evidence.noise.noise_model import Discrepancy
from gap.evidence.noise.uncut import uncut
from gap.evidence.refinement import opened
from gap.evidence.score.changed import changeable
from gap.evidence.score.hypothesis import about, counted, hypothesis_at
from gap.evidence.search_state import EvidenceSearch
from gap.fitting.model import Free, Model
from gap.fitting.simulate import some
from gap.signatures.candidates import candidates


def opening(rig: Rig, free: tuple[Free, ...], experiments: Sequence[Experiment], names: Sequence[str]) -> EvidenceSearch:
    """`experiments`: the fit logs, whole, and the `names` of their channels. Of long ones some windows are chosen."""
    channels, experiments = frozenset(names), [uncut(e, rig, names) for e in experiments]
    model = Model(rig, free, np.array([item.start for item in free]))
    numbers = chosen([velocities(e) for e in experiments])
    few = tuple(some(e, n) for e, n in zip(experiments, numbers, strict=True))
    scales = np.maximum(HONEST * swings(experiments), LEAST_DISCREPANCY)
    seen = about(few, scales, model, counted(few, np.inf))  # as where all friction has another form: nothing is known of it yet
    point = opened(seen, model, Discrepancy(scales.copy(), np.full(len(scales), MEMORY_S), OTHER_FORM))
    nominal = hypothesis_at(seen, (), point)
    count = len(candidates(rig, channels)) + len(changeable(rig, free))
    return EvidenceSearch(rig, channels, seen, nominal, (), (), -float(np.log(max(count / EXPECTED - 1.0, 1.0))))


def swings(experiments: Sequence[Experiment]) -> Array:
    """What every channel does within a window: root mean square about the window's mean, in units of the noise."""
    found = []
    for c in range(experiments[0].measured.shape[2]):
        parts = [p for e in experiments if np.isfinite(p := e.measured[:, :, c] / e.sigma[c]).any()]
        pooled = [(p - np.nanmean(p, axis=1, keepdims=True)).ravel() for p in (p[np.isfinite(p).any(axis=1)] for p in parts)]
        found.append(float(np.sqrt(np.nanmean(np.concatenate(pooled) ** 2))) if pooled else 0.0)
    return np.array(found)
