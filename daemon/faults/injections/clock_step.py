"""A stepped wall clock for the processes of one daemon, without touching the computer's: Python's own clocks are moved."""

from __future__ import annotations

import os
from pathlib import Path

# Read by every interpreter that starts with its directory on PYTHONPATH; the loop's own clock is the monotonic one.
_SITE = """
import time as _time
from pathlib import Path as _Path
_step, _now, _now_ns = _Path(__file__).with_name("step"), _time.time, _time.time_ns
def _offset():
    return int(_step.read_text()) if _step.exists() else 0
_time.time = lambda: _now() + _offset()
_time.time_ns = lambda: _now_ns() + _offset() * 1_000_000_000
"""


def environment(directory: Path) -> dict[str, str]:
    """For the daemon's start."""
    site = directory / "site"
    site.mkdir()
    (site / "sitecustomize.py").write_text(_SITE)
    return {"PYTHONPATH": os.pathsep.join(filter(None, (str(site), os.environ.get("PYTHONPATH", ""))))}


def step(directory: Path, seconds: int) -> None:
    """From now on the wall clock of the daemon's processes is off by this much; all at once."""
    (directory / "site" / "new").write_text(str(seconds))
    (directory / "site" / "new").rename(directory / "site" / "step")
