"""What-if changes: `servo.rotary.gain=0.5 V/deg` applied to the text of a rig file, so that the changed file can be shown and logged."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import Any

import yaml

from config.errors import ConfigError, Mend
from config.options.driver_options import options_schema
from config.parsing.nearest import nearest, nearest_text
from config.parsing.yaml_tree import YamlTree, dotted, end_of, entry, parse
from config.schema.model_fields import bare, fields_of, member_for, place_of_path, union_members
from config.schema.rig import Rig
from config.schema.section import Section
from config.schema.signals import with_inferred

Path = tuple[str | int, ...]


def apply_overrides(text: str, assignments: Iterable[str]) -> str:
    """The rig text with every "key.path=value" put in; comments and layout stay. Values are checked when the result is loaded.

    List entries are numbered from 0: `plant.effects.2.torque=90 N*m`. ConfigError for an unknown key, with the nearest one.
    """
    for assignment in assignments:
        key, equals, value = assignment.partition("=")
        if not equals or not key.strip() or not value.strip():
            what, example = "an override is written key.path=value", "servo.rotary.gain=0.5 V/deg"
            raise ConfigError(what, value=repr(assignment), next_step=f"Example: {example}", mend=as_it_was(text, [assignment]))
        text = _override(text, key.strip(), value.strip())
    return text


def as_it_was(text: str, assignments: Sequence[str], what: str = "") -> Mend:
    """What to write instead of assignments that were refused: what the rig text itself has there, or no --set where it has nothing.

    Of several assignments those count whose key stands in `what`, the refusal.
    """
    mend: dict[str, str | None] = {}
    for assignment in assignments:
        key = assignment.partition("=")[0].strip()
        with suppress(ConfigError):
            path = _resolve(key, "", parse(text, "rig.yaml"))
            if len(assignments) == 1 or dotted(path) in what:
                own = _own(text, path)
                mend |= {assignment: f"{key}={own}"} if own else {"--set": None}
    return mend


def _own(text: str, path: Path) -> str:
    """The text of the value at `path`; empty where there is none, or more than a line."""
    node: yaml.Node = parse(text, "rig.yaml").root
    for part in path:
        found = entry(node, part)
        if found is None:
            return ""
        node = found[1]
    own = text[node.start_mark.index : end_of(node)]
    return "" if "\n" in own else own.strip()


def _override(text: str, key: str, value: str) -> str:
    tree = parse(text, "rig.yaml")
    _check_value(value, key)
    path = _resolve(key, value, tree)
    node: yaml.Node = tree.root
    for depth, part in enumerate(path):
        found = entry(node, part)
        if found is None:
            return _insert(text, node, path[depth:], value)
        node = found[1]
    start, end = node.start_mark.index, end_of(node)
    space = " " if start > 0 and text[start - 1] == ":" else ""
    return text[:start] + space + value + text[end:]


def _resolve(key: str, value: str, tree: YamlTree) -> Path:
    """The path a dotted key means. Names in the file may hold dots themselves (`signals.rotary.position.max_age`)."""
    content = with_inferred(tree.plain)
    path: Path = ()
    words = key.split(".")
    while words:
        known = _known_keys(content, path)
        count = next((count for count in range(len(words), 0, -1) if ".".join(words[:count]) in known), 0)
        if not count:
            where = dotted(path) or "a rig file"
            what = f"{key}: {words[0]!r} is not a key of {where}{nearest_text(words[0], known)}"
            advice = f"Keys of {where}: {', '.join(known)}." if known else ""
            better = ".".join([*key.split(".")[: -len(words)], nearest(words[0], known) or "", *words[1:]])
            mend = {f"{key}={value}": f"{better}={value}"} if nearest(words[0], known) else {}
            raise ConfigError(what, where="override", next_step=advice, mend=mend)
        path = (*path, known[".".join(words[:count])])
        words = words[count:]
    return path


def _known_keys(content: Any, path: Path) -> dict[str, str | int]:
    """What may follow `path`, as written → as stored."""
    value = content
    for part in path:
        value = value.get(part) if isinstance(value, dict) else value[part] if isinstance(value, list) and isinstance(part, int) else None
    annotation = bare(_annotation(content, path))
    if union_members(annotation):
        annotation = member_for(annotation, value)
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return {name: name for name in fields_of(annotation)}
    if isinstance(value, list):
        return {str(index): index for index in range(len(value))}
    return {name: name for name in value} if isinstance(value, dict) else {}


def _annotation(content: Any, path: Path) -> Any:
    """What the schema says about the value at `path`. The options of a device have the schema of its driver."""
    if len(path) >= 3 and (path[0], path[2]) == ("devices", "options"):
        device = content["devices"][path[1]]
        schema = options_schema(str(device.get("driver")))
        if schema is not None:
            return place_of_path(schema, path[3:], device.get("options", {})).annotation
    return place_of_path(Rig, path, content).annotation


def _insert(text: str, node: yaml.Node, missing: Path, value: str) -> str:
    """Add keys that are not written yet to the existing section `node`."""
    first, rest = missing[0], missing[1:]
    for part in reversed(rest):
        value = f"{{{part}: {value}}}"
    start = node.start_mark.index
    if not isinstance(node, yaml.MappingNode):  # `loop:` with nothing after it
        return f"{text[:start]} {{{first}: {value}}}{text[end_of(node) :]}"
    if node.flow_style:
        comma = ", " if node.value else ""
        return f"{text[: start + 1]}{first}: {value}{comma}{text[start + 1 :]}"
    indent = " " * node.start_mark.column
    return f"{text[:start]}{first}: {value}\n{indent}{text[start:]}"


def _check_value(value: str, key: str) -> None:
    """The value must be one line of YAML by itself, or it would change more than its own key."""
    if "\n" in value or " #" in value:
        raise ConfigError("an override is one line without a comment", value=repr(value), where=f"override {key}")
    parse(f"value: {value}", f"override {key}")
