"""Which two runs the first move makes: a maneuver without and with a command filter; on a rig without a link plain moves, fast and slow."""

from __future__ import annotations

from typing import Any

from config.loading.load import find, load_maneuver
from config.schema.rig import Rig
from daemon.cli.operate.motion_commands import maneuver_text
from servo_control.planning.runnable import why_not

LINE = "paper_line"
UNSHAPED = "none"
HOLD_S = 1.5
SHARE, SLOWER_SHARE, SLOWER = 0.1, -0.15, 0.4  # of the travel, either side of its middle; of the rate limit

Request = dict[str, Any]


def two_runs(rig: Rig, maneuver: str, shaper: str) -> dict[str, Request]:
    """Name of a run → its request. `maneuver`: name or file; empty for the paper's line, or plain moves of every joint where the rig cannot
    run it. The first run is fitted by the gap search and the second decides, so they must not be the same."""
    if not maneuver and rig.link_mode is None:
        return {
            "fast": _request(plain_moves(rig, SHARE, 1.0), UNSHAPED),
            "slow": _request(plain_moves(rig, SLOWER_SHARE, SLOWER), UNSHAPED),
        }
    chosen = maneuver_text(maneuver) if maneuver else maneuver_text(LINE) if _runs_the_line(rig) else plain_moves(rig, SHARE, 1.0)
    return {"unshaped": _request(chosen, UNSHAPED), shaper: _request(chosen, shaper)}


def plain_moves(rig: Rig, share: float, rate: float) -> dict[str, str]:
    """Each joint in turn from the middle of its travel by `share` of it and back, at `rate` of its rate limit."""
    start, steps = [], []
    for name, joint in rig.joints.items():
        low, high = joint.travel
        unit, middle = joint.position_unit, 0.5 * (low + high)
        start.append(f"{name}: {middle:.8g} {unit}")
        for goal in (middle + share * (high - low), middle):
            speed = f"{rate * joint.rate_limit:.8g} {unit}/s"
            steps.append(f"  - {{joint: {name}, to: {goal:.8g} {unit}, hold: {HOLD_S} s, speed: {speed}}}\n")
    head = "longreach: maneuver/1\nname: plain_moves\nkind: joint_steps\n"
    return {"text": f"{head}start: {{{', '.join(start)}}}\nsteps:\n{''.join(steps)}", "name": "plain_moves"}


def _runs_the_line(rig: Rig) -> bool:
    return not why_not(rig, load_maneuver(find("maneuvers", LINE)).maneuver)


def _request(maneuver: dict[str, str], shaper: str) -> Request:
    return {"maneuver": maneuver, "shaper": {"kind": shaper}, "approach": True}
