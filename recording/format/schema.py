"""The cycle record as a ROS 2 message definition: text that every viewer understands, and back to our fields.

ROS 2 field names are lower case and its readers refuse others, so `command_V` is stored as `command_v`; the exact name stands
in the comment of its line, with the unit in brackets, and `fields_of_schema` reads it from there.
"""

from __future__ import annotations

import re

from config.errors import LogError
from recording.format.fields import Field

PACKAGE = "longreach_msgs"
SEPARATOR = "=" * 80
_LINE = re.compile(r"^(\S+)\s+(\w+)\s*(?:#\s*(.*))?$")
_COMMENT = re.compile(r"^(\w+) \[([^\]]*)\]:? ?(.*)$")
_PART_TYPE = re.compile(rf"^{PACKAGE}/(\w+)$")


def schema_of_fields(fields: tuple[Field, ...], part_types: dict[str, str]) -> str:
    """ros2msg text of a record. Fields named `part.name` form nested messages; `part_types` gives each part's message name."""
    top: list[str] = []
    nested: dict[str, list[str]] = {}
    for part, members in _by_part(fields).items():
        if not part:
            top += [_line(field) for field in members]
            continue
        top.append(f"{PACKAGE}/{part_types[part]} {part}")
        nested[part_types[part]] = [_line(field) for field in members]
    blocks = ["\n".join(top)]
    blocks += [f"{SEPARATOR}\nMSG: {PACKAGE}/{name}\n" + "\n".join(lines) for name, lines in nested.items()]
    return "\n".join(blocks) + "\n"


def fields_of_schema(text: str) -> tuple[Field, ...]:
    """Fields of a ros2msg text in storage order, nested messages flattened with dots.

    Raises LogError for text that is not a record of fixed-size numbers.
    """
    blocks = re.split(r"^=+\s*\n", text, flags=re.MULTILINE)
    nested = {}
    for block in blocks[1:]:
        head, _, body = block.partition("\n")
        nested[head.removeprefix("MSG:").strip()] = body
    return tuple(_expand(blocks[0], "", nested))


def _expand(body: str, prefix: str, nested: dict[str, str]) -> list[Field]:
    fields: list[Field] = []
    for line in body.splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        match = _LINE.match(line.strip())
        if not match:
            raise LogError("the log's message definition cannot be read", value=repr(line), next_step="Was it written by longreach?")
        ros_type, name, comment = match[1], match[2], match[3] or ""
        if _PART_TYPE.match(ros_type) and ros_type in nested and not prefix:
            fields += _expand(nested[ros_type], f"{name}.", nested)
            continue
        exact = _COMMENT.match(comment)
        fields.append(Field(prefix + exact[1], ros_type, exact[2], exact[3]) if exact else Field(prefix + name, ros_type, "", comment))
    return fields


def _by_part(fields: tuple[Field, ...]) -> dict[str, list[Field]]:
    """Runs of neighbouring fields with the same part. A part's fields must be together, so the text keeps their order."""
    parts: dict[str, list[Field]] = {}
    for field in fields:
        parts.setdefault(field.name.rpartition(".")[0], []).append(field)
    return parts


def _line(field: Field) -> str:
    name = field.name.rpartition(".")[2]
    return f"{field.ros_type} {name.lower()}  # {name} [{field.unit}]: {field.description}"
