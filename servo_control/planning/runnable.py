"""Whether a rig can run a maneuver at all, wherever its arm stands now."""

from __future__ import annotations

from config.errors import ManeuverError
from config.schema.maneuver import Maneuver, maneuver_content
from config.schema.rig import Rig
from servo_control.planning.plan_checks import check_band
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest


def why_not(rig: Rig, maneuver: Maneuver) -> str:
    """What refuses the maneuver without a filter, approached from the middle of the travel; empty when nothing does."""
    middle = [0.5 * (joint.travel[0] + joint.travel[1]) for joint in rig.joints.values()]
    content = maneuver_content(maneuver)
    try:
        check_band(content, rig)
        plan_run(rig, RunRequest(1, content, start_position=middle, approach=True))
    except ManeuverError as error:
        return str(error).removeprefix(f"{maneuver.name}: ")
    return ""
