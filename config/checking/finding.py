"""What a check says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from config.parsing.problems import Problem
from config.parsing.yaml_tree import YamlTree

Level = Literal["ok", "warning", "error"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One statement about a rig. `error`: the rig cannot work as written; `warning`: it works, but perhaps not as meant.

    Every error has its `problem`, whose text it is.
    """

    level: Level
    text: str
    problem: Problem | None = None


def warning_at(tree: YamlTree, path: Sequence[str | int], text: str) -> Finding:
    """A warning that begins with file, line and column of the value at `path`."""
    line, column = tree.mark(path)
    return Finding("warning", f"{tree.name}:{line}:{column}: {text}")


def error_at(tree: YamlTree, path: Sequence[str | int], text: str) -> Finding:
    """An error with its place, as warning_at()."""
    return error_of(tree.problem(path, text))


def error_of(problem: Problem) -> Finding:
    """The error that a problem of the file is."""
    return Finding("error", problem.refusal.text(), problem)
