"""The judge: how probable the hold-out is under a set fitted to other logs, with all that the fit left unsure.

    ln p(hold-out | fitted logs) = ln Z(all logs) − ln Z(fitted logs)

So every set that is judged is fitted on from where it stands with the hold-out beside the fitted logs (MacKay 2003, ch. 28; Vehtari, Gelman
and Gabry 2017). A constant that the fitted logs could not see, and which the hold-out's motion needs, is not held against the set, however
curved the way there is. Held-out logs choose nothing: no set is proposed for what they say.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gap.evidence.noise.discrepancy_search import on_other_logs
from gap.evidence.refinement import FEW_PASSES, descended, finished, hypothesis_of, with_columns
from gap.evidence.score.coordinates import of_other_priors
from gap.evidence.score.hypothesis import Hypothesis, Seen, rediscovered
from gap.evidence.sensitivity import carried_over
from gap.evidence.side_by_side import side_by_side


def on_all_logs(seen: Seen, hypothesis: Hypothesis, held: Seen) -> Hypothesis:
    """The set fitted on with the hold-out beside the fitted logs; its windows are those of the fitted logs, then those of the hold-out.
    `held`: the logs that judge, with what is integrated out there the same for every set."""
    at, there, both = hypothesis.at, carried_over(seen, hypothesis.at, held), together(seen, held)
    readings, jacobian = at.readings + there.readings, at.jacobian + there.jacobian
    point = replace(at, readings=readings, jacobian=jacobian, discrepancy=replace(at.discrepancy, times=()))
    point = replace(point, discrepancy=rediscovered(both, point, None, False))
    return hypothesis_of(both, hypothesis.suspects, descended(both, point))


def led_by(seen: Seen, judged: Hypothesis, other: Hypothesis, held: Seen) -> Hypothesis:
    """A set on all logs, or where it ends from the constants to which another one has come there, if that is better. A larger set may run
    away on a motion it was not fitted to, and no step leads back from there; and a smaller one must not lack the way that the larger one
    has found."""
    both, model = together(seen, held), judged.model
    there = {free.key: number for number, free in enumerate(other.model.free)}
    alike = [(number, there[free.key]) for number, free in enumerate(model.free) if free.key in there]
    own, its = np.array(alike, dtype=np.int64).reshape(-1, 2).T
    theta, columns = model.theta.copy(), [j.copy() for j in judged.at.jacobian]
    theta[own] = np.clip(other.model.theta[its], [model.free[k].low for k in own], [model.free[k].high for k in own])
    for column, known in zip(columns, other.at.jacobian, strict=True):
        column[own] = of_other_priors(known, other.model, model)[its]
    point = with_columns(both, model.with_theta(theta), columns, other.at.discrepancy)
    return max(judged, hypothesis_of(both, judged.suspects, descended(both, point)), key=lambda one: one.log_z)


def ended_on_all_logs(seen: Seen, judged: Hypothesis, held: Seen) -> Hypothesis:
    """What `on_all_logs` gave, with sensitivities of its own there: its interval is reported, and between sets of which either may be
    right the way must not decide."""
    return finished(together(seen, held), judged.suspects, judged.at, FEW_PASSES)


def together(seen: Seen, held: Seen) -> Seen:
    """The fitted logs, then the hold-out, which counts as they do."""
    return Seen(seen.logs + held.logs, seen.scales, seen.model, seen.counts)


def of_rig_file(nominal: Hypothesis, seen: Seen, held: Seen) -> float:
    """ln p(hold-out | fitted logs) of the rig file as it is: nothing of it is unsure but what the logs share."""
    whole, fitted = side_by_side(seen, lambda logs: _as_it_is(nominal, logs), (together(seen, held), seen))
    return whole - fitted


def _as_it_is(nominal: Hypothesis, logs: Seen) -> float:
    left = logs.left(logs.readings(nominal.model))
    return logs.counts * on_other_logs(logs.logs, left, logs.scales, nominal.at.discrepancy)[1]
