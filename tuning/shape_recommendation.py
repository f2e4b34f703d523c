"""Which command filter for these moves: every filter predicted, and the quickest one that stays within the allowed vibration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log10
from typing import Any

import numpy as np

from config.errors import ManeuverError
from config.rig import Rig
from control.planning import plan_run
from control.run_plan import RunPlan
from control.run_request import RunRequest
from control.shaper_choice import KINDS
from tuning.shape_prediction import ERRORS, Prediction, predicted

ALLOWED_MPS2 = 0.1
Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One filter over all maneuvers: residual (m/s²) at no error and worst over the errors, `by_error` the largest hold at each error,
    the largest delay (s). `refused`: why it cannot be used; then there are no numbers."""

    kind: str
    nominal_mps2: float
    worst_mps2: float
    late_s: float
    by_error: tuple[float, ...]
    refused: str = ""


@dataclass(frozen=True, slots=True)
class Recommendation:
    """All filters, unshaped first; `chosen` is one of their kinds, `why` a sentence."""

    candidates: tuple[Candidate, ...]
    errors: tuple[float, ...]
    allowed_mps2: float
    chosen: str
    why: str

    def decibels(self, candidate: Candidate) -> float:
        """Worst residual relative to the unshaped one."""
        return 20.0 * log10(max(candidate.worst_mps2, 1e-9) / self.candidates[0].worst_mps2)


def recommend(
    rig: Rig,
    maneuvers: Sequence[dict[str, Any]],
    shaper: dict[str, Any],
    allowed_mps2: float = ALLOWED_MPS2,
    errors: tuple[float, ...] = ERRORS,
    tell: Tell = lambda line: None,
) -> Recommendation:
    """`maneuvers`: contents as in a run's request; `shaper`: what all filters have in common (joints, focal).

    Raises ManeuverError when a maneuver is not possible even without filter, or the rig has no link.
    """
    candidates = []
    for kind in ("none", *(each for each in KINDS if each != "none")):
        tell(f"predicting {kind}")
        candidates.append(_candidate(rig, maneuvers, {**shaper, "kind": kind}, errors))
    if candidates[0].refused:
        raise ManeuverError("the maneuver is not possible", value=candidates[0].refused)
    chosen, why = _choose(candidates, allowed_mps2)
    return Recommendation(tuple(candidates), errors, allowed_mps2, chosen, why)


def _candidate(rig: Rig, maneuvers: Sequence[dict[str, Any]], shaper: dict[str, Any], errors: tuple[float, ...]) -> Candidate:
    kind = str(shaper["kind"])
    try:
        found = [predicted(rig, _plan(rig, maneuver, shaper), errors) for maneuver in maneuvers]
    except ManeuverError as error:
        return Candidate(kind, np.nan, np.nan, np.nan, (), str(error))
    by_error = np.max(np.vstack([each.residual_mps2 for each in found]), axis=0)
    late = max(float(np.max(each.late_s)) for each in found)
    return Candidate(kind, max(each.nominal_mps2 for each in found), _worst(found), late, tuple(map(float, by_error)))


def _worst(found: Sequence[Prediction]) -> float:
    return max(each.worst_mps2 for each in found)


def _plan(rig: Rig, maneuver: dict[str, Any], shaper: dict[str, Any]) -> RunPlan:
    """From the maneuver's own start, or the middle of the travel."""
    middle = [0.5 * sum(joint.travel) for joint in rig.joints.values()]
    start = [] if maneuver["kind"] == "straight_line" else middle
    return plan_run(rig, RunRequest(1, maneuver, shaper, start_position=start, approach=bool(start)))


def _choose(candidates: Sequence[Candidate], allowed_mps2: float) -> tuple[str, str]:
    usable = [each for each in candidates if not each.refused]
    enough = [each for each in usable if each.worst_mps2 <= allowed_mps2]
    if not enough:
        best = min(usable, key=lambda each: each.worst_mps2)
        return (
            best.kind,
            f"no filter stays below {allowed_mps2:g} m/s² over all errors; {best.kind} comes nearest with {best.worst_mps2:.3f} m/s²",
        )
    if usable[0] in enough:
        return usable[0].kind, f"no filter is needed: {usable[0].worst_mps2:.3f} m/s² at worst without, {allowed_mps2:g} m/s² is allowed"
    best = min(enough, key=lambda each: (round(each.late_s, 2), each.worst_mps2))
    return best.kind, (
        f"{best.kind} is the quickest of {len(enough)} that stay below {allowed_mps2:g} m/s² over all errors: "
        f"{best.worst_mps2:.3f} m/s² at worst, {best.late_s:.2f} s later than planned"
    )
