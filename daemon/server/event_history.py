"""The newest few thousand events, numbered, and what follows from them: the verdict of each run and the last fault."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

from recording.format.event import Event, Level

EVENTS_KEPT = 5000
_LEVEL_NAMES = {int(level): level.name.lower() for level in Level}


@dataclass(slots=True)
class RunResult:
    """`validity` as in the protocol: running, valid, invalid."""

    run: int
    maneuver: str
    shaper: str
    segments: list[list[Any]]
    validity: str = "running"
    reason: str = ""


class EventHistory:
    """Events are numbered from 1. `fault` is the last one while it is latched."""

    def __init__(self) -> None:
        self._events: deque[dict[str, Any]] = deque(maxlen=EVENTS_KEPT)
        self._last_number = 0
        self.runs: dict[int, RunResult] = {}
        self.last_run: RunResult | None = None
        self.fault: dict[str, Any] | None = None

    def add(self, event: Event) -> dict[str, Any]:
        """Store an event of the loop or of the supervisor; returns it as the protocol shows it."""
        self._last_number += 1
        level = _LEVEL_NAMES.get(event.level, str(event.level))
        entry = {"n": self._last_number, "cycle": event.cycle, "t_s": event.t_s, "level": level, "name": event.name, "text": event.text}
        self._events.append({**entry, "values": event.values})
        if event.name == "fault":
            self.fault = {"name": event.name, "text": event.text, "t_s": event.t_s}
        elif event.name == "run_ended":
            self._end_run(event)
        return self._events[-1]

    def begin_run(self, result: RunResult) -> None:
        self.runs[result.run] = self.last_run = result

    def since(self, number: int) -> list[dict[str, Any]]:
        """Events after event `number`, oldest first."""
        return [event for event in self._events if event["n"] > number]

    @property
    def last_number(self) -> int:
        """Of the newest event; 0 before the first."""
        return self._last_number

    def last_text(self, *names: str) -> str:
        """Text of the newest event with one of these names; empty when there is none."""
        return next((str(event["text"]) for event in reversed(self._events) if event["name"] in names), "")

    def _end_run(self, event: Event) -> None:
        result = self.runs.get(int(event.values.get("run", 0)))
        if result is None:
            return
        result.validity = "valid" if event.values.get("valid") else "invalid"
        result.reason = event.text.partition("because ")[2]
