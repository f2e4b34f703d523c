"""Edits of single entries of a YAML text, by the marks of its tree: everything else, comments included, stays as it was written."""

from __future__ import annotations

from collections.abc import Sequence

import yaml

from config.parsing.yaml_tree import YamlTree, end_of, entry

Path = tuple[str | int, ...]


def new_value(tree: YamlTree, path: Path, value: str, why: str) -> str:
    """The scalar at `path` replaced; `why`, with what stood there, is added to the line's comment."""
    _, node = _entry(tree, path)
    start, end = node.start_mark.index, end_of(node)
    was = tree.text[start:end]
    return _noted(tree.text[:start] + value + tree.text[end:], start, f"was {was}: {why}")


def without(tree: YamlTree, path: Path, why: str) -> str:
    """The entry at `path` (a key with a scalar) taken out and kept as a comment."""
    key, node = _entry(tree, path)
    start, end = key.start_mark.index, end_of(node)
    was = tree.text[start:end]
    if _parent(tree, path).flow_style:
        first, last = _with_comma(tree.text, start, end)
        return _noted(tree.text[:first] + tree.text[last:], first, f"was {was}: {why}")
    if _only_entry(tree, path):
        return _emptied(tree, path, f"was {was}: {why}")
    return _noted(f"{tree.text[:start]}# {tree.text[start:]}", start, why)


def moved_up(tree: YamlTree, path: Path, why: str) -> str:
    """The entry at `path` moved from its section into the one around it, before its section."""
    key, node = _entry(tree, path)
    written = tree.text[key.start_mark.index : end_of(node)]
    section, _ = _entry(tree, path[:-1])
    text, at = without(tree, path, why), section.start_mark.index
    if _parent(tree, path[:-1]).flow_style:
        return f"{text[:at]}{written}, {text[at:]}"
    return f"{text[:at]}{written}{_line_end(text)}{' ' * section.start_mark.column}{text[at:]}"


def _entry(tree: YamlTree, path: Sequence[str | int]) -> tuple[yaml.Node, yaml.Node]:
    key, node = tree.root, tree.root
    for part in path:
        found = entry(node, part)
        if found is None:
            raise KeyError(path)
        key, node = found
    return key, node


def _parent(tree: YamlTree, path: Path) -> yaml.MappingNode:
    node = _entry(tree, path[:-1])[1]
    assert isinstance(node, yaml.MappingNode)
    return node


def _only_entry(tree: YamlTree, path: Path) -> bool:
    return len(_parent(tree, path).value) == 1


def _emptied(tree: YamlTree, path: Path, note: str) -> str:
    """A block section whose only entry goes: it becomes an empty mapping, and the entry a comment in its place."""
    key, _ = _entry(tree, path)
    section, _ = _entry(tree, path[:-1])
    colon = tree.text.index(":", section.end_mark.index) + 1
    text = f"{tree.text[: key.start_mark.index]}# {note} | {tree.text[key.start_mark.index :]}"
    return f"{text[:colon]} {{}}{text[colon:]}"


def _with_comma(text: str, start: int, end: int) -> tuple[int, int]:
    """The span of an entry of a flow mapping with the comma that goes with it."""
    after = end + len(text[end:]) - len(text[end:].lstrip())
    if text[after : after + 1] == ",":
        return start, after + 1 + len(text[after + 1 :]) - len(text[after + 1 :].lstrip(" "))
    before = len(text[:start].rstrip())
    return (before - 1 if text[before - 1 : before] == "," else start), end


def _noted(text: str, at: int, note: str) -> str:
    """A comment at the end of the line that holds `at`, after the one that is there."""
    newline = text.find("\n", at)
    end = len(text) if newline < 0 else newline - (text[newline - 1 : newline] == "\r")
    line = text[text.rfind("\n", 0, at) + 1 : end]
    sign = "; " if "#" in line else "  # "
    return f"{text[:end].rstrip(' ')}{sign}{note}{text[end:]}"


def _line_end(text: str) -> str:
    return "\r\n" if "\r\n" in text else "\n"
