"""What a check says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from config.parsing.yaml_tree import YamlTree

Level = Literal["ok", "warning", "error"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One statement about a rig. `error`: the rig cannot work as written; `warning`: it works, but perhaps not as meant."""

    level: Level
    text: str


def warning_at(tree: YamlTree, path: Sequence[str | int], text: str) -> Finding:
    """A warning that begins with file, line and column of the value at `path`."""
    return Finding("warning", _placed(tree, path, text))


def error_at(tree: YamlTree, path: Sequence[str | int], text: str) -> Finding:
    """An error with its place, as warning_at()."""
    return Finding("error", _placed(tree, path, text))


def _placed(tree: YamlTree, path: Sequence[str | int], text: str) -> str:
    line, column = tree.mark(path)
    return f"{tree.name}:{line}:{column}: {text}"
