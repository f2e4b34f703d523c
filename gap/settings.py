"""How a search is run; none of it changes what counts as a finding."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

# Processors this process may use, at most 8: windows are too few to keep more busy.
PROCESSORS = min(len(os.sched_getaffinity(0)), 8)


@dataclass(frozen=True, slots=True)
class Settings:
    """`window_s`: length of the windows compared (default: by the kind of arm). `workers`: threads of the simulations (1 where many
    searches run beside each other). `propose`: whether look-alikes get a maneuver that would separate them, which simulates several.
    `request`: maneuver file, or run request as JSON, of the first hold-out log: what the report runs again where that log does not say.
    `keep_remainder`: whether an unnamed remainder is put into the improved rig file, where the hold-out falls with it.
    `si`: whether the report has SI units instead of the rig file's.
    """

    window_s: float | None = None
    workers: int = PROCESSORS
    propose: bool = True
    request: Path | None = None
    keep_remainder: bool = False
    si: bool = False
