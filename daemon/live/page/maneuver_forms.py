"""The shipped maneuvers with what can be changed in each, as their files state it: what the page makes its forms of."""

from __future__ import annotations

from typing import Any

from config.loading.load import load_maneuver, read_text
from config.loading.shipped import shipped
from config.parsing.yaml_tree import parse
from config.schema.maneuver import maneuver_content

_NOT_CHANGED = ("longreach", "name", "kind", "description")


def maneuver_forms() -> list[dict[str, Any]]:
    """name, kind, description, `parameters`: key → text as in the file, of all but the nested ones."""
    forms = []
    for path in shipped("maneuvers").values():
        content = maneuver_content(load_maneuver(path).maneuver)
        written = parse(read_text(path), str(path)).plain
        parameters = {key: _text(value) for key, value in written.items() if key not in _NOT_CHANGED and _is_plain(value)}
        forms.append({**{key: content[key] for key in ("name", "kind", "description")}, "parameters": parameters})
    return forms


def _is_plain(value: Any) -> bool:
    return not isinstance(value, dict) and not (isinstance(value, list) and any(isinstance(each, dict | list) for each in value))


def _text(value: Any) -> str:
    """As it would stand in the file, on one line."""
    if isinstance(value, list):
        return f"[{', '.join(map(_text, value))}]"
    return str(value).lower() if isinstance(value, bool) else str(value)
