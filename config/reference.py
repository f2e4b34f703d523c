"""Writes docs/reference/*.md from the schema: every section, key, unit, range, default and description.

`python -m config.reference` rewrites the files; a test keeps them equal to the schema.
"""

from __future__ import annotations

import datetime
import inspect
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from config.calibration_record import CalibrationRecord
from config.import_map import ImportMap
from config.maneuver import AnyManeuver
from config.plant import Plant
from config.rig import Rig
from config.schema import bare, choices, fields_of, limits, union_members
from config.section import Section, is_inferred, unit_of
from config.signals import JOINT_SIGNALS, RIG_SIGNALS

REFERENCE = Path(__file__).parents[1] / "docs" / "reference"

_UNITS = """\
A number may carry a unit: `2000 psi`, `0.35 V/deg`, `30 in`, `100 in/s^2`, `45 lb`, `40 degC`. A bare number is in the unit of the
table. Angle counts as a dimension: where rad/s is asked for, `5 Hz` is refused and `5 turn/s` is right. Anchors, aliases and merge
keys of YAML are not used; unknown and repeated keys are errors.
"""
_WORDS = {float: "number", int: "whole number", str: "text", bool: "true or false", datetime.date: "day, YYYY-MM-DD", Any: "anything"}


def pages() -> dict[str, str]:
    """File name → text of every reference page."""
    return {
        "rig.md": _page("Rig file", "A rig file begins with `longreach: rig/1`.", Rig) + _signal_names(),
        "plant.md": _page("Plant section", "The section `plant` of a rig file: the simulated rig.", Plant, ".plant"),
        "import_map.md": _page("Import map", "A map of `longreach import` begins with `longreach: map/1`.", ImportMap),
        "calibration.md": _page(
            "Calibration record", "A record of `longreach identify` begins with `longreach: calibration/1`.", CalibrationRecord
        ),
        "maneuver.md": _page("Maneuver file", "A maneuver file begins with `longreach: maneuver/1`.", AnyManeuver),
    }


def _page(title: str, start: str, annotation: Any, path: str = "") -> str:
    head = f"# {title}\n\nGenerated from the schema by `python -m config.reference`; do not edit.\n\n{start}\n\n{_UNITS}"
    return head + "".join(_sections(path, annotation, is_top=True))


def _signal_names() -> str:
    """The names a signal can have; JOINT stands for the name of a joint."""
    rows = [*((f"JOINT.{name}", measures) for name, measures in JOINT_SIGNALS.items()), *RIG_SIGNALS.items()]
    table = "".join(f"| `{name}` | {'angle or length' if measures == 'position' else measures} |\n" for name, measures in rows)
    note = (
        "`JOINT.position` is required for every joint. `JOINT.second_position`, another sensor of the same motion, is logged and compared, "
        "never controlled with. Pressures are gauge; the tip's deflection is positive towards growing rotary angle."
    )
    return f"\n## Names of signals\n\n{note}\n\n| name | measures |\n|---|---|\n{table}"


def _sections(path: str, annotation: Any, *, is_top: bool = False) -> Iterator[str]:
    """The part of one section (or of each member of a union), then those of the sections inside it."""
    annotation = bare(annotation)
    members = [member for _, member in union_members(annotation)]
    if len(members) == 1:
        yield from _sections(path, members[0])
    elif members:
        for member in members:
            if _is_section(member):
                yield from _section(path, member, _variant(member))
    elif get_origin(annotation) is dict:
        yield from _sections(f"{path}.NAME", get_args(annotation)[1])
    elif get_origin(annotation) in (tuple, list):
        yield from _sections(f"{path}[]", get_args(annotation)[0])
    elif annotation is Plant and not is_top:
        yield f"\n## `{path.removeprefix('.')}`\n\nSee [plant.md](plant.md).\n"
    elif _is_section(annotation):
        yield from _section(path, annotation, "")


def _section(path: str, section: type[Section], variant: str) -> Iterator[str]:
    fields = fields_of(section)
    title = " ".join(part for part in (f"`{path.removeprefix('.')}`" if path else "", variant) if part) or "Sections"
    about = inspect.cleandoc(section.__doc__) if "__doc__" in vars(section) and section.__doc__ else ""
    rows = "".join(_row(key, field) for key, field in fields.items())
    text = f"\n## {title}\n\n" + (f"{about}\n\n" if about else "")
    yield text + (f"| key | meaning | unit | allowed | default |\n|---|---|---|---|---|\n{rows}" if rows else "")
    for key, field in fields.items():
        yield from _sections(f"{path}.{key}", field.annotation)


def _variant(section: type[Section]) -> str:
    """ "with `motion: rotary`", or for an inferred key "(angle, from the signal's name)"."""
    for key, words in choices(section).items():
        field = section.model_fields[key]
        if is_inferred(field):
            return f"({words[0]}, {field.description})"
        return "with " + " or ".join(f"`{key}: {word}`" for word in words)
    return f"({section.__name__})"


def _row(key: str, field: FieldInfo) -> str:
    unit = unit_of(field)
    cells = (f"`{key}`", field.description or _summary(field.annotation), unit or "", _allowed(field), _default(field))
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def _summary(annotation: Any) -> str:
    """The first sentence about a section that is the value of a key."""
    annotation = bare(annotation)
    if members := union_members(annotation):
        return _summary(members[0][1]) if len(members) == 1 else ""
    if _is_section(annotation) and "__doc__" in vars(annotation):
        return inspect.cleandoc(annotation.__doc__ or "").split("\n")[0]
    return ""


def _allowed(field: FieldInfo) -> str:
    annotation = bare(field.annotation)
    low, high = limits(field)
    kind = _type_text(annotation)
    if low is not None and high is not None:
        return f"{kind}, {low:.6g} to {high:.6g}"
    if low is not None:
        return f"{kind}, at least {low:.6g}"
    return f"{kind}, at most {high:.6g}" if high is not None else kind


def _type_text(annotation: Any) -> str:
    annotation = bare(annotation)
    members = [member for _, member in union_members(annotation)]
    if members:
        return " or ".join(dict.fromkeys(_type_text(member) for member in members))
    if get_origin(annotation) is Literal:
        return ", ".join(f"`{word}`" for word in get_args(annotation))
    if get_origin(annotation) is dict:
        return f"NAME: {_type_text(get_args(annotation)[1])}"
    if get_origin(annotation) in (tuple, list):
        return _list_text(get_args(annotation))
    return "section" if _is_section(annotation) else _WORDS.get(annotation, "text")


def _list_text(items: tuple[Any, ...]) -> str:
    kinds = [_type_text(item) for item in items if item is not Ellipsis]
    return f"list of {kinds[0]}" if Ellipsis in items or len(items) == 1 else f"[{', '.join(kinds)}]"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "**required**"
    value = field.get_default(call_default_factory=True, validated_data={})
    if value is None or value in ("", (), {}) or isinstance(value, Section):
        return "none" if not isinstance(value, Section) else ""
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


def _is_section(annotation: Any) -> bool:
    return isinstance(annotation, type) and not isinstance(annotation, types.GenericAlias) and issubclass(annotation, Section)


def main() -> None:
    REFERENCE.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        (REFERENCE / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
