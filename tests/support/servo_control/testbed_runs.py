"""Short ways to ask the testbed for runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from config.loading.load import find, load_maneuver
from config.schema.maneuver import maneuver_content, maneuver_from_content
from servo_control.planning.run_request import RunRequest

INCH = 0.0254


def shipped(name: str) -> dict[str, Any]:
    return maneuver_content(load_maneuver(find("maneuvers", name)).maneuver)


def content(kind: str, **values: Any) -> dict[str, Any]:
    """A maneuver's content as a run request carries it, from what a user would write."""
    return maneuver_content(maneuver_from_content({"longreach": "maneuver/1", "name": "test", "kind": kind, **values}))


def request(maneuver: dict[str, Any], start: Sequence[float] = (), shaper: dict[str, Any] | None = None, **more: Any) -> RunRequest:
    return RunRequest(more.pop("run", 1), maneuver, shaper or {"kind": "none"}, start_position=list(start), **more)
