"""From logs cut into windows to the search before its first stage: the rig file as it is, beside what it can be expected to leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from config.schema.rig import Rig
from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import EXPECTED, HONEST, LEAST_DISCREPANCY, MEMORY_S, OTHER_FORM
from gap.evidence.noise.discrepancy import expected
from gap.evidence.noise.uncut import uncut
from gap.evidence.refinement import opened
from gap.evidence.score.changed import changeable
from gap.evidence.score.hypothesis import about, counted, hypothesis_at
from gap.evidence.search_state import EvidenceSearch
from gap.fitting.model import Free, Model
from gap.fitting.simulate import of_every_regime
from gap.suspects.candidates import candidates


def opening(rig: Rig, free: tuple[Free, ...], experiments: Sequence[Experiment], names: Sequence[str]) -> EvidenceSearch:
    """`experiments`: the fit logs, whole, and the `names` of their channels. Of long ones some windows are chosen."""
    channels, experiments = frozenset(names), [uncut(e, rig, names) for e in experiments]
    model = Model(rig, free, np.array([item.start for item in free]))
    few = of_every_regime(experiments)
    scales = np.maximum(HONEST * swings(experiments), LEAST_DISCREPANCY)
    seen = about(few, scales, model, counted(few, 1.0))  # as where all friction has another form: nothing is known of it yet
    point = opened(seen, model, expected(scales, OTHER_FORM))
    nominal = hypothesis_at(seen, (), point)
    count = len(candidates(rig, channels)) + len(changeable(rig, free))
    return EvidenceSearch(rig, channels, seen, nominal, (), (), -float(np.log(max(count / EXPECTED - 1.0, 1.0))))


def swings(experiments: Sequence[Experiment]) -> Array:
    """What every channel does within the discrepancy's memory: root mean square of its changes over MEMORY_S, in units of the noise."""
    found = []
    for c in range(experiments[0].measured.shape[2]):
        changes = np.concatenate([_changes(e, c) for e in experiments])
        found.append(float(np.sqrt(np.mean(changes**2))) if len(changes) else 0.0)
    return np.array(found)


def _changes(experiment: Experiment, channel: int) -> Array:
    times = experiment.times_s
    lag = max(1, round(MEMORY_S / float(times[0, 1] - times[0, 0])))
    values = experiment.measured[:, :, channel] / experiment.sigma[channel]
    moved = values[:, lag:] - values[:, :-lag]
    return np.asarray(moved[np.isfinite(moved)])
