"""What the improved rig file is written with: a set's constants fitted to the fit logs and the hold-out together.

Names come from the fit logs and are judged by the hold-out; then nothing is left for it to judge, and a constant that only its motion shows
should have the value that it shows. What predicted the hold-out blind is kept beside that (`fit_logs` in findings.json).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.deciding_numbers import RANGE_SDS
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import stretch
from gap.evidence.score.hypothesis import Hypothesis, Seen, posterior
from gap.fitting.common_scale import at_own_scale
from gap.fitting.confidence import confidence
from gap.fitting.evaluation import Costing, evaluate
from gap.fitting.fit import Fit, covariance, unfitted
from gap.fitting.model import Free, Model
from gap.outcome.as_stated import as_stated
from gap.outcome.names import Fitted
from gap.outcome.search_state import SearchState


def on_all_logs(state: SearchState, seen: Seen, hypothesis: Hypothesis) -> Fitted:
    """A set that was fitted to all logs (`seen`: those of the fit, then the hold-out), at the common scale that priors and logs want, with
    constants as stated that the logs do not speak for."""
    done = at_own_scale(as_fit(hypothesis, [*state.experiments, *state.judging], state.costs), state.costs)
    model = as_stated(done.model, covariance(done, state.costs))
    return Fitted(model, np.maximum(confidence(done, state.costs), half_width(seen, hypothesis)))


def as_fit(hypothesis: Hypothesis, experiments: Sequence[Experiment], costs: Costing) -> Fit:
    """The model as it was fitted, in the costs of the report. `experiments`: those it was fitted to. Sensitivities that the search has let
    go are taken again."""
    model, known = as_constants(hypothesis), hypothesis.at.jacobian
    rescaled = (model.scales / hypothesis.model.scales / stretch(hypothesis.model))[:, None, None, None]
    jacobian = [rescaled * j * e.sigma for j, e in zip(known, experiments, strict=True)] if known else None
    return unfitted(model, [evaluate(e, model, costs) for e in experiments], costs, jacobian)


def half_width(seen: Seen, hypothesis: Hypothesis) -> Array:
    """95 % of the posterior, of every free number in its unit; logs count as they do for the names (ζ)."""
    sd = np.sqrt(np.diag(np.linalg.inv(posterior(seen, hypothesis.at).precision)))
    return np.asarray(1.96 * sd * hypothesis.model.scales * stretch(hypothesis.model))


def as_constants(hypothesis: Hypothesis) -> Model:
    """Numbers that have changed as constants of wide priors, which the file is written with."""
    changed = {s.free.key for s in hypothesis.suspects if isinstance(s, Changed)}
    return replace(hypothesis.model, free=tuple(_wide(f) if f.key in changed else f for f in hypothesis.model.free))


def _wide(free: Free) -> Free:
    return replace(free, prior=True, scale=max(free.high - free.start, free.start - free.low) / RANGE_SDS)
