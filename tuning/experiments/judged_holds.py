"""In which holds of a planned run the vibration can be judged, by the rule for logs (`recording.evaluation.vibration`)."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from recording.evaluation.vibration import APPROACH, window_s
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.run_plan import RunPlan


@dataclass(frozen=True, slots=True)
class JudgedHold:
    """The hold after a move: planned end of the move (s), where the link is then (m) and how it rings there (Hz), and the window (s
    after that end)."""

    move: str
    end_s: float
    extension_m: float
    frequency_Hz: float
    window_s: tuple[float, float]


def judged_holds(plan: RunPlan, link: LinkFrequency) -> tuple[list[JudgedHold], list[str]]:
    """The holds that are long enough, and the moves whose holds are not."""
    found, too_short = [], []
    for number, move in enumerate(plan.segments):
        rest_s = _rest_s(plan, number)
        if move.kind != "move" or move.name == APPROACH or rest_s <= 0.0:
            continue
        extension_m = plan.program.at(move.end_s, plan.program.next_index(0, move.end_s))[0][1]
        frequency_Hz = link.frequency_Hz(extension_m)
        window = window_s(rest_s, frequency_Hz)
        if window is None:
            too_short.append(move.name)
        else:
            found.append(JudgedHold(move.name, move.end_s, extension_m, frequency_Hz, window))
    return found, too_short


def _rest_s(plan: RunPlan, number: int) -> float:
    """How long nothing moves after a segment; after the last one for good."""
    following = (later.start_s for later in plan.segments[number + 1 :] if later.kind != "hold")
    return next(following, inf) - plan.segments[number].end_s
