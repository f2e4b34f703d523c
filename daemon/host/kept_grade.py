"""What `longreach host` has found, kept for the daemon: the rates of this computer, when they were seen, and what they hold for.

It counts beside a load, for the same computer (kernel, processors, governor, interpreter), the same wishes of the rig's `loop` section, the
same devices, and where no right is refused that was granted then; anything else may keep other rates. The service reads its state
directory, so root measures for it; without a service the user's own is meant.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.whole_file import write_whole
from daemon.host.host_facts import host

if TYPE_CHECKING:
    from config.schema.rig import Rig

FILE_NAME = "host_grade.json"
SERVICE_STATE_DIRECTORY = Path("/var/lib/longreach")
_NEXT_STEP = "`longreach host --load --rig RIG` measures it; end the daemon first."

_DEVICES = "devices"


@dataclass(frozen=True, slots=True)
class HostGrade:
    """`grade_Hz`: every rate up to it was kept, 0 for none; `loaded`: beside other work; `refused`: rights that the system did not grant;
    `holds_for`: see measured_for."""

    grade_Hz: float
    measured_utc: str
    loaded: bool
    refused: tuple[str, ...]
    holds_for: Mapping[str, Any]

    def text(self) -> str:
        return f"{self.grade_Hz:g} Hz, seen {self.measured_utc} UTC{' beside a load' if self.loaded else ''}"


def measured_for(rig: Rig) -> dict[str, Any]:
    """All that a measurement depends on but the rate: this computer, the rig's loop, its devices (a digest of their section)."""
    loop, over = rig.loop, rig.loop.overruns
    wishes = {
        "spin_s": loop.spin_s,
        "priority": loop.priority,
        "cpu": loop.cpu,
        "window_s": over.window_s,
        "stop_after": over.stop_after,
        "fault_late_s": over.fault_late_s,
    }
    devices = json.dumps({name: device.model_dump(mode="json") for name, device in sorted(rig.devices.items())}, sort_keys=True)
    return {
        **host(),
        **{f"loop.{name}": value for name, value in wishes.items()},
        _DEVICES: hashlib.sha256(devices.encode()).hexdigest()[:12],
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
        content = json.loads(path.read_text())
        return HostGrade(**{**content, "refused": tuple(content["refused"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None


class KeptGrade:
    """The kept grade as one rig's daemon sees it; `look` again now and then, because somebody may measure meanwhile.

    `rate_Hz`: 0 where no measurement counts; `said`: what was found and why it does not count.
    """

    def __init__(self, rig: Rig) -> None:
        self._path, self._now = grade_path(), measured_for(rig)
        self._looked_at: tuple[int, frozenset[str]] | None = None
        self.look()

    def look(self, refused: Collection[str] = ()) -> None:
        """`refused`: rights that this daemon was not granted."""
        try:
            written_ns = self._path.stat().st_mtime_ns
        except OSError:
            written_ns = 0
        if self._looked_at == (written_ns, frozenset(refused)):
            return
        self._looked_at, grade = (written_ns, frozenset(refused)), kept(self._path)
        self.rate_Hz, self.said = 0.0, "nothing measured"
        if grade is None:
            return
        other = self._other(grade, refused)
        self.rate_Hz = 0.0 if other else grade.grade_Hz
        self.said = f"{grade.text()}, which does not count: {other}" if other else grade.text()

    def _other(self, grade: HostGrade, refused: Collection[str]) -> str:
        """The first thing that was not then as it is now; empty where all is the same."""
        if not grade.loaded:
            return "it was measured without a load"
        for name, value in self._now.items():
            if value != grade.holds_for.get(name):
                return "the rig's devices were others" if name == _DEVICES else f"{name} was {grade.holds_for.get(name)}"
        lost = sorted(set(refused) - set(grade.refused))
        return f"{lost[0]} was granted" if lost else ""

    def row(self) -> dict[str, Any]:
        """As a line of `longreach why`, whether the rig demands a rate or not."""
        rest = {"limit": "", "unit": "", "source": str(self._path), "severity": "info", "next_step": _NEXT_STEP}
        return {"name": "rates seen before", "ok": True, "value": self.said, **rest}
