"""Columns of a table → columns of a log: by an import map, or by their names when these are those of the log already."""

from __future__ import annotations

import shlex

import numpy as np

from config.errors import LogError, UnitError
from config.loading.import_map import ImportMap, LoadedMap, SourceColumn
from config.parsing.nearest import nearest_text
from config.parsing.problems import Problem, config_error
from config.schema.rig import Rig
from config.units import to_si
from recording.format.layout import CycleLayout, measured_twice
from recording.importing.table import Floats, SourceTable

_NEEDED = (".position", ".command_V")
_SIGN_OF_A_JOINT = (".position", ".command_V", ".target", ".reference")


def columns_by_name(table: SourceTable, rig: Rig | None) -> tuple[CycleLayout, dict[str, Floats]]:
    """The table's own columns that the log knows. Joints come from the rig, or from names such as `boom.position`."""
    twice = measured_twice((*table.columns, *(rig.signals if rig is not None else ())))
    joints = {name: joint.motion for name, joint in rig.joints.items()} if rig is not None else None
    layout = CycleLayout(tuple(joints), list(joints.values()), twice) if joints else CycleLayout(_joints_named_in(table), None, twice)
    units = {field.name: field.unit for field in layout.fields}
    dated = next((name for name in sorted(table.dates) if units.get(name, "s") != "s"), "")
    if dated:
        advice = "Only a time may be a date; leave the column out, or name it otherwise."
        raise LogError(f"column {dated!r} holds dates or times of day", where=str(table.path), next_step=advice)
    return layout, {name: values for name, values in table.columns.items() if layout.has(name)}


def columns_by_map(table: SourceTable, loaded: LoadedMap) -> tuple[CycleLayout, dict[str, Floats]]:
    """What the map makes of the table. ConfigError for names or units that do not fit.

    LogError where the table lacks the time, a position or a command; what else it lacks is missing in this log alone: see `lacking`.
    """
    layout = CycleLayout(tuple(loaded.map.joints), list(loaded.map.joints.values()), measured_twice(loaded.map.columns))
    _refuse_unknown_names(loaded, layout)
    _refuse_missing_columns(table, loaded.map)
    units = {field.name: field.unit for field in layout.fields}
    there = {name: entry for name, entry in loaded.map.columns.items() if entry.source in table.columns}
    columns = {name: _converted(table, loaded, name, entry, units[name]) for name, entry in there.items()}
    for name, value in loaded.map.constants.items():
        columns[name] = np.full(table.rows, _in_unit(loaded, ("constants", name), str(value), units[name]))
    return layout, columns


def lacking(table: SourceTable, wanted: ImportMap) -> list[str]:
    """A sentence for every column of the map that the table does not have."""
    return [
        f"{name} is missing: the table has no {entry.source}{nearest_text(entry.source, table.columns)}."
        for name, entry in wanted.columns.items()
        if entry.source not in table.columns
    ]


def _joints_named_in(table: SourceTable) -> tuple[str, ...]:
    named = [name.rpartition(".")[0] for name in table.columns if name.endswith(_SIGN_OF_A_JOINT)]
    joints = tuple(dict.fromkeys(joint for joint in named if joint and joint != "tip"))
    if joints:
        return joints
    known = [field.name for field in CycleLayout(("rotary", "prismatic")).fields]
    seen = ", ".join(name + nearest_text(name, known) for name in list(table.columns)[:12])
    propose = f"`longreach import {shlex.quote(str(table.path))} --suggest` proposes one"
    advice = f"Name the columns as in a log (t_s, rotary.position, rotary.command_V, ...), or give a map with --map; {propose}."
    raise LogError("no column of the table is a joint's position or command", value=seen, where=str(table.path), next_step=advice)


def _refuse_unknown_names(loaded: LoadedMap, layout: CycleLayout) -> None:
    known = [field.name for field in layout.fields]
    problems: list[Problem] = []
    for section in ("columns", "constants"):
        for name in getattr(loaded.map, section):
            if not layout.has(name):
                what = f"{name!r} is no column of a log of these joints{nearest_text(name, known)}"
                problems.append(loaded.tree.problem((section, name), what, of_key=True, next_step="docs/method/log.md lists the columns."))
            elif section == "constants" and name in loaded.map.columns:
                problems.append(loaded.tree.problem((section, name), f"{name!r} is both a column and a constant", of_key=True))
    if problems:
        raise config_error(loaded.tree.name, problems)


def _refuse_missing_columns(table: SourceTable, wanted: ImportMap) -> None:
    needed = {name: entry for name, entry in wanted.columns.items() if name == "t_s" or name.endswith(_NEEDED)}
    missing = [entry.source for entry in needed.values() if entry.source not in table.columns]
    if missing:
        seen = ", ".join(dict.fromkeys(name + nearest_text(name, table.columns) for name in missing))
        advice = f"The table has: {', '.join(table.columns)}."
        raise LogError(f"the table lacks columns that the map {wanted.name} needs", value=seen, where=str(table.path), next_step=advice)


def _converted(table: SourceTable, loaded: LoadedMap, name: str, entry: SourceColumn, unit: str) -> Floats:
    """Units convert by slope and intercept; a column that needs neither is passed on bit for bit."""
    if entry.source in table.dates:
        _refuse_other_than_seconds(loaded, name, entry, unit)
    values = table.columns[entry.source]
    if (entry.scale, entry.offset) != (1.0, 0.0):
        values = entry.offset + entry.scale * values
    if entry.unit is None or entry.unit == unit:
        return values
    at_zero = _in_unit(loaded, ("columns", name, "unit"), f"0 {entry.unit}", unit)
    at_one = _in_unit(loaded, ("columns", name, "unit"), f"1 {entry.unit}", unit)
    return at_zero + (at_one - at_zero) * values


def _refuse_other_than_seconds(loaded: LoadedMap, name: str, entry: SourceColumn, unit: str) -> None:
    """A column of dates, which are seconds whatever its name says."""
    if unit != "s" or entry.unit not in (None, "s"):
        path = ("columns", name, "unit") if entry.unit else ("columns", name)
        what = f"column {entry.source!r} of the table holds dates or times of day, which are read as seconds"
        raise config_error(loaded.tree.name, [loaded.tree.problem(path, what, value=entry.unit or unit, next_step="Write unit: s.")])


def _in_unit(loaded: LoadedMap, path: tuple[str, ...], text: str, unit: str) -> float:
    try:
        return to_si(text, "" if unit == "counts" else unit)
    except UnitError as error:
        refusal = error.refusal
        raise config_error(
            loaded.tree.name, [loaded.tree.problem(path, refusal.what, value=refusal.value, next_step=refusal.next_step)]
        ) from error
