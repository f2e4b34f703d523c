"""Which command filter for these moves: every filter predicted on ideal joints and on the whole simulated rig, and the quickest one that
stays within the allowed vibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import log10
from typing import Any

import numpy as np

from config.errors import ManeuverError
from config.progress import Progress
from config.schema.rig import Rig
from servo_control.planning.mending import plan_or_mend
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan, TipMotion
from servo_control.planning.run_request import RunRequest
from servo_control.shapers.shaper_choice import KINDS
from tuning.shaper_choice.coupled_prediction import can_be_coupled, predicted_coupled
from tuning.shaper_choice.shape_prediction import ERRORS, Prediction, predicted

ALLOWED_MPS2 = 0.1


@dataclass(frozen=True, slots=True)
class Residual:
    """One filter over all maneuvers: vibration left (m/s²) at no error of the frequency and worst over the errors, the largest hold at
    each of `errors`, the largest delay (s). `too_short`: moves whose holds are, and which nothing is said of."""

    nominal_mps2: float
    worst_mps2: float
    late_s: float
    errors: tuple[float, ...]
    by_error: tuple[float, ...]
    too_short: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ShaperCandidate:
    """`ideal`: on joints that follow exactly; `coupled`: on the whole simulated rig, None where the rig file has no plant or was not
    asked. `refused`: why the filter cannot be used; then there are neither. `tip`: the fastest of the maneuvers' tip motions."""

    kind: str
    ideal: Residual | None
    coupled: Residual | None = None
    refused: str = ""
    tip: TipMotion | None = None

    @property
    def judged(self) -> Residual:
        """By what it is recommended or not."""
        best = self.coupled or self.ideal
        assert best is not None
        return best


@dataclass(frozen=True, slots=True)
class Recommendation:
    """All filters, unshaped first; `chosen` is one of their kinds, `why` a sentence."""

    candidates: tuple[ShaperCandidate, ...]
    allowed_mps2: float
    chosen: str
    why: str

    @property
    def best(self) -> ShaperCandidate:
        return next(each for each in self.candidates if each.kind == self.chosen)

    def decibels(self, candidate: ShaperCandidate) -> float:
        """Worst residual relative to the unshaped one."""
        return 20.0 * log10(max(candidate.judged.worst_mps2, 1e-9) / self.candidates[0].judged.worst_mps2)


def recommend(
    rig: Rig,
    maneuvers: Sequence[dict[str, Any]],
    shaper: dict[str, Any],
    allowed_mps2: float = ALLOWED_MPS2,
    errors: tuple[float, ...] = ERRORS,
    coupled: bool = True,
    progress: Progress = lambda line: None,
) -> Recommendation:
    """`maneuvers`: contents as in a run's request; `shaper`: what all filters have in common (joints, focal). `coupled`: also run every
    filter on the rig file's plant, at the first, the middle and the last of the errors, and judge by that.

    Raises ManeuverError when a maneuver is not possible even without filter, or the rig has no link.
    """
    candidates = []
    for kind in ("none", *(each for each in KINDS if each != "none")):
        progress(f"predicting {kind}")
        try:
            candidates.append(_candidate(rig, maneuvers, {**shaper, "kind": kind}, errors, coupled and can_be_coupled(rig)))
        except ManeuverError as error:
            if kind == "none":
                raise
            candidates.append(ShaperCandidate(kind, None, refused=str(error)))
    chosen, why = _choose(candidates, allowed_mps2)
    return Recommendation(tuple(candidates), allowed_mps2, chosen, why)


def _candidate(
    rig: Rig, maneuvers: Sequence[dict[str, Any]], shaper: dict[str, Any], errors: tuple[float, ...], coupled: bool
) -> ShaperCandidate:
    kind = str(shaper["kind"])
    plans = [_plan(rig, maneuver, shaper) for maneuver in maneuvers]
    ideal = _residual([predicted(rig, plan, errors) for plan in plans])
    tip = max((plan.tip for plan in plans if plan.tip is not None), key=lambda each: each.speed_mps, default=None)
    few = tuple(dict.fromkeys((errors[0], errors[len(errors) // 2], errors[-1])))
    whole = _residual([predicted_coupled(rig, plan, few) for plan in plans]) if coupled else None
    return ShaperCandidate(kind, ideal, whole, tip=tip)


def _residual(found: Sequence[Prediction]) -> Residual:
    by_error = np.max(np.vstack([each.residual_mps2 for each in found]), axis=0)
    late = max(float(np.max(each.late_s)) for each in found)
    errors = tuple(map(float, found[0].errors))
    nominal = max(each.nominal_mps2 for each in found)
    too_short = tuple(dict.fromkeys(move for each in found for move in each.too_short))
    return Residual(nominal, max(each.worst_mps2 for each in found), late, errors, tuple(map(float, by_error)), too_short)


def _plan(rig: Rig, maneuver: dict[str, Any], shaper: dict[str, Any]) -> RunPlan:
    """From the maneuver's own start, or the middle of the travel."""
    middle = [0.5 * sum(joint.travel) for joint in rig.joints.values()]
    start = [] if maneuver["kind"] == "straight_line" else middle
    request = RunRequest(1, maneuver, shaper, start_position=start, approach=bool(start))
    return plan_or_mend(rig, request) if shaper["kind"] == "none" else plan_run(rig, request)


def _choose(candidates: Sequence[ShaperCandidate], allowed_mps2: float) -> tuple[str, str]:
    usable = [(each, each.judged) for each in candidates if not each.refused]
    enough = [(each, judged) for each, judged in usable if judged.worst_mps2 <= allowed_mps2]
    if not enough:
        best, left = min(usable, key=lambda pair: pair[1].worst_mps2)
        why = f"no filter stays below {allowed_mps2:g} m/s² over all errors; {best.kind} comes nearest with {left.worst_mps2:.3f} m/s²"
        return best.kind, why
    unshaped, left = usable[0]
    if left.worst_mps2 <= allowed_mps2:
        return unshaped.kind, f"no filter is needed: {left.worst_mps2:.3f} m/s² at worst without, {allowed_mps2:g} m/s² is allowed"
    best, left = min(enough, key=lambda pair: (round(pair[1].late_s, 2), pair[1].worst_mps2))
    return best.kind, (
        f"{best.kind} is the quickest of {len(enough)} that stay below {allowed_mps2:g} m/s² over all errors: "
        f"{left.worst_mps2:.3f} m/s² at worst, {left.late_s:.2f} s later than planned"
    )
