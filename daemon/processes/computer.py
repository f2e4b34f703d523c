"""The computer under the daemon, looked at once a second: room for logs, the rate that it was seen to keep, the rights it granted."""

from __future__ import annotations

import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from config.schema.rig import Rig
from daemon.host.kept_grade import KeptGrade

EVERY_S = 1.0


class ComputerWatch:
    """`disk_free_bytes`: where recordings go; `granted`: rows of what the loop was granted, once it has said so."""

    def __init__(self, rig: Rig, log_dir: Path) -> None:
        self._grade, self._log_dir = KeptGrade(rig), log_dir
        self._next_look = self.disk_free_bytes = 0.0
        self.granted: Sequence[dict[str, Any]] = ()

    @property
    def rate_Hz(self) -> float:
        """0 where no measurement counts."""
        return self._grade.rate_Hz

    @property
    def grade(self) -> str:
        return self._grade.said

    def rows(self) -> list[dict[str, Any]]:
        """As lines of `longreach why`."""
        return [*self.granted, self._grade.row()]

    def look(self) -> None:
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + EVERY_S
        self.disk_free_bytes = _free_bytes(self._log_dir)
        self._grade.look([row["name"] for row in self.granted if row["severity"] == "warning"])


def _free_bytes(log_dir: Path) -> float:
    """The folder is made again when it was moved away. 0 where none can be written."""
    try:
        log_dir.mkdir(parents=True, exist_ok=True)
        return float(shutil.disk_usage(log_dir).free)
    except OSError:
        return 0.0
