"""Where a number of the rig file comes from: the tag in the comment of its line, as in `carriage: 11.3 kg  # [A] rod and piston`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from config.parsing.yaml_tree import Path, YamlTree

FIXED = "fixed"  # no search moves the number
TAGS = ("P", "DS", "M", "B", "D", "C", "A", "gap", FIXED)
_COMMENT = re.compile(r"(?:^|\s)#(.*)$")
_WORD = re.compile(r"\[([A-Za-z]{1,8})\]")


def tag_of(tree: YamlTree, path: Path) -> str:
    """The tag on the line of a value: "P" for `# [P] stated`, the first of several, `fixed` wherever it stands among them; empty without
    one. A key not written has its default: assumed."""
    if tree.value(path) is None:
        return "A"
    line, _ = tree.mark(path)
    tags = [word for word in bracketed(tree.text.splitlines()[line - 1]) if word in TAGS]
    return FIXED if FIXED in tags else tags[0] if tags else ""


def bracketed(line: str) -> list[str]:
    """Single words in brackets of a line's comment."""
    comment = _COMMENT.search(line)
    return _WORD.findall(comment[1]) if comment else []


def fixed_numbers(tree: YamlTree) -> list[Path]:
    """Places of the plant section that a fit may not move."""
    return [path for path in _leaves(tree.value(("plant",)), ("plant",)) if tag_of(tree, path) == FIXED]


def _leaves(node: Any, path: Path) -> Iterator[Path]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in items:
        if isinstance(value, (dict, list)):
            yield from _leaves(value, (*path, key))
        elif _is_quantity(value):
            yield (*path, key)


def _is_quantity(value: Any) -> bool:
    if isinstance(value, str):
        return bool(re.match(r"\s*[-+]?\.?\d", value))
    return isinstance(value, (int, float)) and not isinstance(value, bool)
