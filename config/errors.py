"""The one exception tree of longreach.

    LongreachError                 every refusal the user may see
    ├── ConfigError                a rig, maneuver or map file cannot be used (carries file:line:column)
    │   └── UnitError              a quantity has the wrong unit or cannot be read
    ├── ManeuverError              a maneuver cannot run on this rig (outside the workspace, too fast, ...)
    ├── DriverError                a device did not answer, or answered wrongly
    ├── LogError                   a log cannot be read, repaired or re-executed
    │   └── WriteError             a log, table, picture or page cannot be written
    ├── DaemonError                the daemon refuses a request (not armed, busy, a check failed, ...)
    └── PlantError                 the simulated plant cannot be built or has left its valid range

Every message says what, value, limit, unit, where and what to do next; `Refusal` holds these parts so that the command line
can print them as text and as JSON without taking sentences apart. `mend` names what was given and does not fit, with a value that
does: a key of the maneuver ("y0": "0.31 m"), an option ("--joint": "rotary"; "" for one that stands alone, None to leave it out), or a
word as it was typed.

Exit statuses of the command line: 0 done, 1 refused (any LongreachError), 2 wrong usage, 3 unusable data.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, TypedDict, Unpack

_TYPED = re.compile(r"`((?:longreachd?|systemctl|journalctl|df|ls|ip|pip) [^`]*)`")

EXIT_REFUSED = 1
EXIT_USAGE = 2
EXIT_UNUSABLE_DATA = 3
EXIT_INTERRUPTED = 130

Mend = Mapping[str, str | None]


@dataclass(frozen=True, slots=True)
class Refusal:
    """The parts of a message to a user. Only `what` is required; text() joins the parts that are given."""

    what: str
    value: str = ""
    limit: str = ""
    unit: str = ""
    where: str = ""
    next_step: str = ""
    mend: Mend = field(default_factory=dict)

    def text(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        unit = f" {self.unit}" if self.unit else ""
        if self.value:
            head += f": {self.value}{unit}"
        if self.limit:
            head += f" (limit: {self.limit}{unit})"
        stop = "" if head.endswith(".") else "."  # a value may be a sentence
        return f"{head}{stop} {self.next_step}" if self.next_step else head

    def as_dict(self) -> dict[str, Any]:
        return {key: value for key, value in asdict(self).items() if value}

    def named_command(self) -> str:
        """The command that the message names in backquotes, its next step's first; empty where it names none."""
        named = _TYPED.search(self.next_step) or _TYPED.search(self.what)
        return named[1] if named else ""


class Parts(TypedDict, total=False):
    """Of a message, as keywords; a value and a limit may be given as they are."""

    value: object
    limit: object
    unit: str
    where: str
    next_step: str
    mend: Mend


class LongreachError(Exception):
    """Base of all refusals. Raise a subclass with the parts of its message as keywords."""

    exit_status = EXIT_REFUSED

    def __init__(self, what: str, **parts: Unpack[Parts]) -> None:
        value, limit = str(parts.get("value", "")), str(parts.get("limit", ""))
        others = parts.get("unit", ""), parts.get("where", ""), parts.get("next_step", ""), parts.get("mend", {})
        self.refusal = Refusal(what, value, limit, *others)
        super().__init__(self.refusal.text())


class ConfigError(LongreachError):
    """Example: unknown key 'gian' in servo.rotary (nearest: 'gain'). `problems` holds every problem of the file, in its order."""

    def __init__(self, what: str, *, problems: tuple[Refusal, ...] = (), **parts: Unpack[Parts]) -> None:
        super().__init__(what, **parts)
        self.problems = problems or (self.refusal,)


class UnitError(ConfigError):
    """Example: supply pressure given as '2000 kg'."""


class ManeuverError(LongreachError):
    """Example: the straight line at y0 = 10 in needs an extension below 12 in."""


class DriverError(LongreachError):
    """Example: encoder node 3 did not answer within 0.2 s."""


class LogError(LongreachError):
    """Example: the file was cut at t = 12.3 s; run `longreach log recover`."""

    exit_status = EXIT_UNUSABLE_DATA


class WriteError(LogError):
    """Example: the table cannot be written: no space left on device. No data are at fault."""

    exit_status = EXIT_REFUSED


class DaemonError(LongreachError):
    """Example: start refused, the rig is disarmed."""


class PlantError(LongreachError):
    """Example: a chamber volume of the simulated cylinder is negative."""


class UsageError(LongreachError):
    """Words of a command that do not go together."""

    exit_status = EXIT_USAGE
