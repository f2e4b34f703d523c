"""What the operator asks for: everything a run depends on besides the rig file. JSON goes into the log and back unchanged."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from config.errors import ManeuverError

FIRST_PLANNING, LATEST_PLANNING = 1, 2
BY_HAND = "stream"  # kind of a maneuver without a program: set points say where the arm goes


@dataclass(frozen=True, slots=True)
class RunRequest:
    """`maneuver`: maneuver_content(...); `shaper`: see shaper_choice; `start_position`: where the arm is.

    `repeat`: how often the program runs. `approach`: move slowly to the program's start first when the arm is elsewhere.
    `planning`: which planning made it, so that a logged run is planned again as it was; a request without it is of the first.
    """

    run: int
    maneuver: dict[str, Any]
    shaper: dict[str, Any] = field(default_factory=lambda: {"kind": "none"})
    repeat: int = 1
    start_position: list[float] = field(default_factory=list)
    approach: bool = False
    planning: int = LATEST_PLANNING

    @property
    def by_hand(self) -> bool:
        """Driven by set points: there is no program to plan."""
        return self.maneuver.get("kind") == BY_HAND

    def as_json(self) -> str:
        """One JSON object; numbers keep every bit."""
        return json.dumps(asdict(self), allow_nan=False)

    @staticmethod
    def from_json(text: str | bytes) -> RunRequest:
        """The inverse of as_json. Raises ManeuverError for other content."""
        try:
            content = json.loads(text)
        except ValueError as error:
            raise ManeuverError("the run request is not JSON", value=str(error)) from error
        known = {item.name for item in fields(RunRequest)}
        if not isinstance(content, dict) or not {"run", "maneuver"} <= content.keys() <= known:
            raise ManeuverError(
                "the run request has wrong keys",
                value=sorted(content) if isinstance(content, dict) else type(content).__name__,
                limit=sorted(known),
                next_step="Give at least run and maneuver.",
            )
        request = RunRequest(**{"planning": FIRST_PLANNING, **content})
        if not FIRST_PLANNING <= request.planning <= LATEST_PLANNING:
            raise ManeuverError(
                "the run was planned by another version of longreach",
                value=request.planning,
                limit=f"{FIRST_PLANNING} to {LATEST_PLANNING}",
                next_step="Use that version.",
            )
        return request
