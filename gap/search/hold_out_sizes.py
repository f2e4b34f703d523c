"""The smallest visible size as the hold-out sees it: there every decision is made, and it may show less of an effect than the fit logs.

An effect of a given size that is missing leaves on the hold-out what its signature there is, less what the constants do that were fitted
to it on the fit logs. With that added to the cost of every window, the size must pass the gates of a candidate that takes it away again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.data.strata import chosen
from gap.data.windows import velocities
from gap.fitting.compare import paired_t
from gap.fitting.evaluation import Costing, Evaluation, evaluate, mean_cost, values_compared
from gap.fitting.fit import Fit, unfitted
from gap.fitting.model import Model
from gap.fitting.simulate import remembering, some
from gap.fitting.thinned import TO_SIZE, thinned
from gap.search.select import least_t, passes
from gap.search.trial import excess
from gap.signatures.projection import ConstantsProjection, Probe, changes, probed
from gap.signatures.screen import Screening
from gap.signatures.visible import scalable, sized

MOST_WINDOWS = 30  # of the hold-outs together: enough to see how many of them agree
ROUNDS = 2  # an effect that is not proportional to its size is simulated again where it would have to be larger
PROPORTIONAL = 3.0  # factor up to which an effect counts as proportional
LARGEST = 100.0  # factor beyond which an effect counts as invisible on these logs
_BISECTIONS = 6


def on_hold_out(screening: Screening, current: Fit, seen: Sequence[Evaluation], costs: Costing, tried: int) -> Screening:
    """The screening with every size raised to what the hold-out would have let pass. `tried`: candidates among which it would have been
    found. An effect that would have to be larger than is plausible has no size."""
    known = {k: s for k, s in enumerate(screening.signatures) if s.probe and scalable(s) and np.isfinite(s.smallest_visible)}
    if not known:
        return screening
    sizes = {k: s.smallest_visible for k, s in known.items()}
    probes = {k: s.probe for k, s in known.items() if s.probe}
    judge = Judge(current, seen, costs, least_t(tried))
    for _ in range(ROUNDS):
        least = judge.least_sizes(probes, sizes)
        far = [k for k in probes if PROPORTIONAL < least[k] / sizes[k] < LARGEST]
        sizes |= least
        models = {k: model for k in far if (model := sized(known[k], sizes[k])) is not None}
        if not models:
            break
        probes = judge.probed(models, sizes)
    plausible = {k: size if sized(known[k], size) is not None else np.inf for k, size in sizes.items()}
    signatures = tuple(replace(s, smallest_visible=plausible.get(k, s.smallest_visible)) for k, s in enumerate(screening.signatures))
    return replace(screening, signatures=signatures)


class Judge:
    """Signatures on the hold-out, and the size of each that passes the gates. `least`: the t that a candidate needs."""

    def __init__(self, current: Fit, seen: Sequence[Evaluation], costs: Costing, least: float) -> None:
        self._fitted, _ = thinned(current, TO_SIZE)
        self._projection = ConstantsProjection(self._fitted, costs)
        few, share = _fewer(current.model, seen, costs)
        self._held = unfitted(current.model, few, costs)
        self._least = least * float(np.sqrt(share))

    def probed(self, models: Mapping[int, Model], sizes: Mapping[int, float]) -> dict[int, Probe]:
        """Effects at other sizes on the fit logs."""
        found = probed(self._fitted, self._projection, list(models.values()), [sizes[k] for k in models])
        return dict(zip(models, found, strict=True))

    def least_sizes(self, probes: Mapping[int, Probe], sizes: Mapping[int, float]) -> dict[int, float]:
        """The smallest size, from `sizes` on, at which each effect is named on the hold-out, as if proportional to its probe."""
        changed = changes(self._held, [probe.model for probe in probes.values()])
        answers = np.stack([probe.answers for probe in probes.values()])
        left = [part - np.tensordot(answers, columns, 1) for part, columns in zip(changed, self._held.columns, strict=True)]
        energies = [np.sum(part**2, axis=2) / values_compared(e.experiment) for part, e in zip(left, self._held.evaluations, strict=True)]
        return {
            k: sizes[k] * self._factor([energy[row] * (sizes[k] / probe.size) ** 2 for energy in energies])
            for row, (k, probe) in enumerate(probes.items())
        }

    def _factor(self, energies: Sequence[Array]) -> float:
        if self._passes(energies, 1.0):
            return 1.0
        low, high = 1.0, 2.0
        while not self._passes(energies, high):
            low, high = high, 2.0 * high
            if low > LARGEST:
                return np.inf
        for _ in range(_BISECTIONS):
            middle = float(np.sqrt(low * high))
            low, high = (low, middle) if self._passes(energies, middle) else (middle, high)
        return high

    def _passes(self, energies: Sequence[Array], factor: float) -> bool:
        after = self._held.evaluations
        before = [replace(e, window_costs=e.window_costs + factor**2 * energy) for e, energy in zip(after, energies, strict=True)]
        drop = mean_cost(before) - mean_cost(after)
        return passes(paired_t(before, after), drop / excess(mean_cost(before)), drop, self._least)


def _fewer(model: Model, seen: Sequence[Evaluation], costs: Costing) -> tuple[list[Evaluation], float]:
    """As many windows of the hold-out as are enough, reached from the states that the model has there, and the share of them."""
    numbers = chosen([velocities(e.experiment) for e in seen], MOST_WINDOWS)
    found = [_part(model, e, few, costs) for e, few in zip(seen, numbers, strict=True)]
    return found, sum(map(len, numbers)) / sum(e.experiment.windows for e in seen)


def _part(model: Model, seen: Evaluation, numbers: NDArray[np.int64], costs: Costing) -> Evaluation:
    if len(numbers) == seen.experiment.windows:
        return seen
    return evaluate(remembering(some(seen.experiment, numbers), model.vector()), model, costs, seen.projection.of_windows(numbers))
