"""When something was late: whether a step's words say so, and whose lateness it was as far as the loop has seen."""

from __future__ import annotations

import re

from daemon.checks.declared.daemon_health import RECORDER_SILENT, STALL, TIMING
from daemon.modes.run_watch import MISSED

_LATE = (STALL.name, TIMING.name, RECORDER_SILENT.name)
_LATE_SIGNAL = (" age", " quality")  # a device whose frames stay away has samples of bad quality
_NAMES_SIGNAL = re.compile(r"[\w.]+ (age|quality)\b")


def ended_late(reason: str) -> bool:
    """Whether a run ended because this computer did not keep time or a sample came late, as far as its reason says."""
    check = reason.removeprefix("fault: ").partition(" (")[0]
    return check in _LATE or check.endswith(_LATE_SIGNAL) or MISSED in reason


def tells_of_lateness(text: str) -> bool:
    """Whether any check that is named in a refusal or an outcome is one of lateness."""
    return MISSED in text or any(name in text for name in _LATE) or _NAMES_SIGNAL.search(text) is not None


def whose(overruns: int, cycles: int, rig_file: str) -> str:
    """`overruns`: late ends among the loop's `cycles` in that step. What to do, and how it goes on."""
    on = f"`longreach commission {rig_file}` goes on with this step."
    host = f"`longreach host --load --rig {rig_file}`"
    if overruns:
        seen = f"{overruns} of {cycles} cycles of the loop ended late meanwhile"
        return f"{seen}: this computer is late. With the daemon ended, {host} says what holds it up; then {on}"
    return (
        f"The loop itself kept time in its {cycles} cycles: look at the device and its bus, `longreach status` shows what its link counts. "
        f"Is the device a twin on this computer, with the daemon ended {host} says what holds it up. Then {on}"
    )
