"""Every number the loop knows in one cycle, as one flat list of floats with names: the log row first, then what only checks need.

The same list is checked by the interlocks, published to the supervisor and shown by `longreach why`, so none of them can disagree.
"""

from __future__ import annotations

from math import nan

from config.canopen_options import proofs
from config.rig import Rig
from config.signals import SECOND_POSITION
from daemon.link_watch import link_facts
from recording.layout import CycleLayout

# Of every joint, in its unit: see daemon.plausibility.
PLAUSIBILITY_FACTS = ("position_rate", "position_noise", "stuck_motion", "unexplained_motion")

APART_FACT = "positions_apart"  # of a joint with two position sensors

SWING_FACT = "tip.swing_mps2"  # where the tip's acceleration is measured, see daemon.swing

# What only checks and status need; the log row does not hold it.
_LOOP_FACTS = (
    "estop_latched",  # 1 until a reset
    "loop.late_s",  # how long after the next deadline the last cycle ended
    "loop.overruns_in_window",
    "recorder.age_s",  # since the recorder last reported
    "recorder.failed",  # 1 when it has ended or cannot write
    "recorder.drops",  # records lost since this recording began
    "disk.free_bytes",
    "supervisor.age_s",  # since the supervisor last reported
    "commands",  # requests carried out since the start
    "run.number",  # last run asked for; 0 for none
    "run.countdown_s",
    "run.elapsed_s",
    "run.duration_s",
    "run.verdict",  # see daemon.run_watch.Verdict
)


def calibration_facts(rig: Rig) -> dict[str, str]:
    """Signal → fact with the days its calibration still holds, for calibrations that end."""
    return {name: f"{name}.calibration_days_left" for name, signal in rig.signals.items() if signal.calibration.valid_until}


class Facts:
    """Names and places of the numbers of one rig. `values` in the loop is a list made by blank()."""

    def __init__(self, rig: Rig, layout: CycleLayout) -> None:
        row = [field.name for field in layout.fields]
        quality = [f"{signal}.quality" for signal in rig.signals]
        following = [f"{joint}.following_error" for joint in rig.joints]
        plausible = [f"{joint}.{fact}" for joint in rig.joints for fact in PLAUSIBILITY_FACTS]
        plausible += [f"{joint}.{APART_FACT}" for joint in rig.joints if f"{joint}.{SECOND_POSITION}" in rig.signals]
        self.row_length = len(row)
        proven = [f"{device}.proven_s" for device in proofs(rig)]  # when its safe state was proven, in the loop's time
        swing = [SWING_FACT] if "tip.acceleration" in rig.signals else []
        unknown = [*proven, *calibration_facts(rig).values(), *swing]
        counts = [fact for facts in link_facts(rig).values() for fact in facts]
        self.names = (*row, *quality, *following, *plausible, *_LOOP_FACTS, *unknown, *counts)
        zeros = [0.0] * (len(following) + len(plausible) + len(_LOOP_FACTS))
        self._blank = [*layout.blank(), *[2.0 for _ in quality], *zeros, *[nan for _ in unknown], *[0.0 for _ in counts]]
        self.places = {name: number for number, name in enumerate(self.names)}

    def index(self, name: str) -> int:
        """KeyError for no fact of this rig."""
        return self.places[name]

    def has(self, name: str) -> bool:
        return name in self.places

    def blank(self) -> list[float]:
        """Nothing measured yet: log row as layout.blank(), qualities BAD, nothing proven or calibrated, the rest 0."""
        return list(self._blank)
