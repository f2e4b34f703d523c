"""The rooms of gap/ import one way, as its docstring says."""

from __future__ import annotations

import ast
from pathlib import Path

import gap

ROOMS = ("data", "balance", "fitting", "search", "maneuvers", "report")
FOLDER = Path(next(iter(gap.__path__)))


def imported(path: Path) -> set[str]:
    """Rooms that a file of gap/ imports from; "" stands for gap/ itself."""
    names = [node.module for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom) and node.module]
    within = [name.split(".") for name in names if name.split(".")[0] == "gap"]
    return {parts[1] if len(parts) > 1 and parts[1] in ROOMS else "" for parts in within}


def test_every_room_imports_only_from_those_before_it() -> None:
    files = [(path, number) for number, room in enumerate(ROOMS) for path in (FOLDER / room).glob("*.py")]
    assert len(files) > 60
    for path, number in files:
        assert imported(path) <= set(ROOMS[: number + 1]), path
