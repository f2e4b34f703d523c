"""`longreach twin`, running."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from config.rig import Rig
from sim_backend.twin.control_socket import TwinControl


@dataclass
class TwinProcess:
    """The running twin, the rig file it has, and its control socket."""

    process: subprocess.Popen[str]
    rig: Rig
    rig_file: Path
    control: TwinControl
