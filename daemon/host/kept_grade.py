"""What `longreach host` has found, kept for the daemon: the rates of this computer, when they were seen, and what they hold for.

It counts for the same computer (kernel, processors, governor, interpreter) and the same wishes of the rig's `loop` section; anything else
may keep other rates. The service reads its state directory, so root measures for it; without a service the user's own is meant.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.whole_file import write_whole
from daemon.host.host_facts import host

if TYPE_CHECKING:
    from config.schema.rig import Loop

FILE_NAME = "host_grade.json"
SERVICE_STATE_DIRECTORY = Path("/var/lib/longreach")
_NEXT_STEP = "`longreach host --load --rig RIG` measures it."


@dataclass(frozen=True, slots=True)
class HostGrade:
    """`grade_Hz`: every rate up to it was kept, 0 for none; `loaded`: beside other work; `host`, `wishes`: what it holds for."""

    grade_Hz: float
    measured_utc: str
    loaded: bool
    host: Mapping[str, str]
    wishes: Mapping[str, Any]

    def text(self) -> str:
        return f"{self.grade_Hz:g} Hz, seen {self.measured_utc} UTC{' beside a load' if self.loaded else ''}"


def wishes_of(loop: Loop) -> dict[str, Any]:
    """Of a rig's loop, all that a measurement depends on but the rate."""
    over = loop.overruns
    return {
        "spin_s": loop.spin_s,
        "priority": loop.priority,
        "cpu": loop.cpu,
        "window_s": over.window_s,
        "stop_after": over.stop_after,
        "fault_late_s": over.fault_late_s,
    }


def grade_path() -> Path:
    """In systemd's StateDirectory=, the service's where it exists, or this user's."""
    from_systemd = os.environ.get("STATE_DIRECTORY")
    if from_systemd:
        return Path(from_systemd) / FILE_NAME
    if SERVICE_STATE_DIRECTORY.is_dir():
        return SERVICE_STATE_DIRECTORY / FILE_NAME
    return Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "longreach" / FILE_NAME


def keep(grade: HostGrade) -> Path:
    """In place of what was kept before. LogError when the system refuses."""
    path = grade_path()
    write_whole(path, json.dumps(dataclasses.asdict(grade), indent=1), "host grade")
    return path


def kept(path: Path) -> HostGrade | None:
    """None where nothing was kept, or nothing that can be read."""
    try:
        return HostGrade(**json.loads(path.read_text()))
    except (OSError, ValueError, TypeError):
        return None


class KeptGrade:
    """The kept grade as one rig's daemon sees it; `look` again now and then, because somebody may measure meanwhile.

    `rate_Hz`: 0 where no measurement counts; `said`: what was found and why it does not count.
    """

    def __init__(self, loop: Loop) -> None:
        self._path, self._now = grade_path(), {**host(), **_named(wishes_of(loop))}
        self._looked_at_ns = -1
        self.look()

    def look(self) -> None:
        try:
            written_ns = self._path.stat().st_mtime_ns
        except OSError:
            written_ns = 0
        if written_ns == self._looked_at_ns:
            return
        self._looked_at_ns, grade = written_ns, kept(self._path)
        self.rate_Hz, self.said = 0.0, "nothing measured"
        if grade is None:
            return
        then = {**grade.host, **_named(grade.wishes)}
        other = next((name for name, value in self._now.items() if value != then.get(name)), "")
        self.rate_Hz = 0.0 if other else grade.grade_Hz
        self.said = f"{grade.text()}, which does not count: {other} was {then.get(other)}" if other else grade.text()

    def row(self) -> dict[str, Any]:
        """As a line of `longreach why`, whether the rig demands a rate or not."""
        rest = {"limit": "", "unit": "", "source": str(self._path), "severity": "info", "next_step": _NEXT_STEP}
        return {"name": "rates seen before", "ok": True, "value": self.said, **rest}


def _named(wishes: Mapping[str, Any]) -> dict[str, Any]:
    """By their place in the rig file, without units."""
    return {f"loop.{name}": value for name, value in wishes.items()}
