"""The judge: how probable the hold-out is under a set fitted to other logs, with all that the fit left unsure.

    ln p(hold-out | fitted logs) = ln Z(all logs) − ln Z(fitted logs)

So every set that is judged is fitted on from where it stands with the hold-out beside the fitted logs (MacKay 2003, ch. 28; Vehtari, Gelman
and Gabry 2017). A constant that the fitted logs could not see, and which the hold-out's motion needs, is not held against the set, however
curved the way there is. Held-out logs choose nothing: no set is proposed for what they say.
"""

from __future__ import annotations

from dataclasses import replace

from gap.evidence.noise.discrepancy import on_other_logs
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.refinement import descended, hypothesis_of
from gap.evidence.score.coordinates import slopes
from gap.evidence.score.hypothesis import Hypothesis, Seen
from gap.fitting.simulate import simulate


def on_all_logs(seen: Seen, hypothesis: Hypothesis, held: Seen) -> Hypothesis:
    """The set fitted on with the hold-out beside the fitted logs; its windows are those of the fitted logs, then those of the hold-out.
    `held`: the logs that judge, with what is integrated out there the same for every set."""
    at, vector = hypothesis.at, hypothesis.model.vector()
    readings = tuple(simulate(e, [vector])[0] for e in held.experiments)
    more = slopes(at.model, held.experiments, range(len(at.model.free)), readings)
    jacobian = tuple(in_noise(e, j) for e, j in zip(held.experiments, more, strict=True))
    point = replace(at, readings=at.readings + readings, jacobian=at.jacobian + jacobian, discrepancy=replace(at.discrepancy, times=()))
    both = Seen(seen.experiments + held.experiments, seen.scales, seen.unknowns + held.unknowns, seen.model)
    return hypothesis_of(both, hypothesis.suspects, descended(both, hypothesis_of(both, hypothesis.suspects, point).at))


def of_rig_file(nominal: Hypothesis, held: Seen) -> float:
    """ln p(hold-out) of the rig file as it is: nothing of it is unsure."""
    at, vector = nominal.at, nominal.model.vector()
    left = held.left(tuple(simulate(e, [vector])[0] for e in held.experiments))
    return on_other_logs(held.experiments, left, held.unknowns, held.scales, at.discrepancy)[1]
