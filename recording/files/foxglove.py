"""A layout for the Foxglove viewer, attached to every log: open the log, import the attachment, and the plots are there.

Foxglove reads a layout as JSON: `configById` has one entry a panel ("Plot!name"), `layout` is a tree of splits. Message paths use
the lower-case names of the message definition.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from recording.files.writer import CYCLE_TOPIC, EVENT_TOPIC
from recording.format.layout import RecordLayout

_COLOURS = ("#4e98e2", "#f5774d", "#3aa655", "#b07aa1", "#9c755f", "#e15759")
_TIP = ("tip.acceleration_mps2", "tip.deflection_m")


def foxglove_layout(layout: RecordLayout) -> bytes:
    """JSON of a layout for logs of this record: a column of plots for every joint, one for tip, pressures, modes and events."""
    panels: dict[str, Any] = {}
    columns = [_joint_column(joint, panels) for joint in layout.joint_names]
    columns.append(_rig_column(layout, panels))
    content = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("row", columns),
    }
    return json.dumps(content, indent=1).encode()


def _joint_column(joint: str, panels: dict[str, Any]) -> Any:
    plots = {
        f"{joint}: position": [f"{joint}.{name}" for name in ("target", "reference", "position")],
        f"{joint}: rate": [f"{joint}.{name}" for name in ("reference_rate", "velocity")],
        f"{joint}: command": [f"{joint}.command_V"],
    }
    return _split("column", [_plot(title, names, panels) for title, names in plots.items()])


def _rig_column(layout: RecordLayout, panels: dict[str, Any]) -> Any:
    pressures = [f"{joint}.{name}" for joint in layout.joint_names for name in ("supply_pressure_Pa", "return_pressure_Pa")]
    tip = [_plot(f"tip: {name.split('.')[1]}", [name], panels) for name in _TIP if layout.has(name)]
    panels["StateTransitions!modes"] = {
        "title": "Mode, run, segment",
        "isSynced": True,
        "paths": [{"value": _path(name), "timestampMethod": "receiveTime"} for name in ("mode", "maneuver", "segment")],
    }
    panels["Table!events"] = {"title": "Events", "topicPath": EVENT_TOPIC}
    timing = _plot("timing", ["late_us", "read_us", "compute_us", "write_us"], panels)
    return _split("column", [*tip, _plot("pressures", pressures, panels), "StateTransitions!modes", timing, "Table!events"])


def _plot(title: str, names: Sequence[str], panels: dict[str, Any]) -> str:
    panel = f"Plot!{title.replace(': ', '-').replace(' ', '-')}"
    panels[panel] = {
        "title": title,
        "paths": [
            {"value": _path(name), "label": name, "enabled": True, "color": colour, "timestampMethod": "receiveTime"}
            for name, colour in zip(names, _COLOURS * (1 + len(names) // len(_COLOURS)), strict=False)
        ],
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "isSynced": True,
        "xAxisVal": "timestamp",
    }
    return panel


def _path(name: str) -> str:
    return f"{CYCLE_TOPIC}.{name.lower()}"


def _split(direction: str, parts: list[Any]) -> Any:
    """A tree of two-way splits that gives all parts the same room."""
    if len(parts) == 1:
        return parts[0]
    return {"direction": direction, "first": parts[0], "second": _split(direction, parts[1:]), "splitPercentage": 100.0 / len(parts)}
