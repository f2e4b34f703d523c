"""The house: imports run one way between folders, between the rooms of a folder and between their files, as the docstrings say."""

from __future__ import annotations

import ast
import re
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
# Each folder may import those before it.
FOLDERS = ("config", "servo_control", "sim_backend", "drivers", "recording", "tuning", "gap", "daemon", "longreach")
MOST_FILES = 15  # at one level of a folder
WIDE = {"sim_backend.effects"}  # one file an effect, found by its name


def modules() -> dict[str, Path]:
    """Dotted name → file of everything in the house; a package by the name of its folder."""
    named: dict[str, Path] = {}
    for folder in FOLDERS:
        for path in sorted((CHECKOUT / folder).rglob("*.py")):
            parts = path.relative_to(CHECKOUT).with_suffix("").parts
            named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


MODULES = modules()
PACKAGES = sorted(name for name, path in MODULES.items() if path.name == "__init__.py")


def imported(path: Path) -> set[str]:
    """Modules of the house that a file imports, wherever in the file it does."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.add(whole if whole in MODULES else node.module)
        elif isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
    return found & MODULES.keys()


@cache
def imports() -> dict[str, set[str]]:
    """Module → modules of the house that it imports. All files are read, so not while tests are collected."""
    return {name: imported(path) for name, path in MODULES.items()}


def arrows(package: str) -> dict[str, set[str]]:
    """Child of a package (file or room) → children it imports; "" is the whole house."""
    prefix = f"{package}." if package else ""
    inside = {name: targets for name, targets in imports().items() if name.startswith(prefix)}
    graph: dict[str, set[str]] = {}
    for name, targets in inside.items():
        child = name[len(prefix) :].split(".")[0]
        met = {target[len(prefix) :].split(".")[0] for target in targets if target.startswith(prefix)}
        graph.setdefault(child, set()).update(met - {child})
    return graph


def rooms(package: str) -> list[str]:
    return [name.rpartition(".")[2] for name in PACKAGES if name.rpartition(".")[0] == package]


def listed(package: str) -> list[str]:
    """The rooms that a package's docstring names, in its order."""
    docstring = ast.get_docstring(ast.parse(MODULES[package].read_text())) or ""
    return re.findall(r"^- (\w+): ", docstring, re.MULTILINE)


@pytest.mark.parametrize("package", ["", *PACKAGES])
def test_imports_make_no_circle(package: str) -> None:
    try:
        tuple(TopologicalSorter(arrows(package)).static_order())
    except CycleError as circle:
        pytest.fail(f"{package or 'the house'}: {' -> '.join(reversed(circle.args[1]))}")


def test_folders_import_only_those_before_them() -> None:
    graph = arrows("")
    assert set(graph) == set(FOLDERS)
    for folder, targets in graph.items():
        assert targets <= set(FOLDERS[: FOLDERS.index(folder)]), folder


@pytest.mark.parametrize("package", [name for name in PACKAGES if rooms(name)])
def test_rooms_import_only_those_their_docstring_lists_before_them(package: str) -> None:
    order = listed(package)
    assert sorted(order) == rooms(package)
    graph = arrows(package)
    for number, room in enumerate(order):
        assert graph.get(room, set()) & set(order) <= set(order[:number]), f"{package}.{room}"


@pytest.mark.parametrize("package", PACKAGES)
def test_every_room_says_what_lives_there(package: str) -> None:
    docstring = ast.get_docstring(ast.parse(MODULES[package].read_text())) or ""
    assert len(docstring) > 40, package


@pytest.mark.parametrize("package", sorted(set(PACKAGES) - WIDE))
def test_no_level_is_crowded(package: str) -> None:
    files = [path for path in MODULES[package].parent.glob("*.py") if path.name != "__init__.py"]
    assert len(files) <= MOST_FILES, f"{package}: {len(files)} files"


@pytest.mark.parametrize(("folder", "ending"), [("benchmarks", "py"), ("tests", "py"), ("docs", "md")])
def test_no_folder_beside_the_rooms_is_crowded(folder: str, ending: str) -> None:
    files = Counter(path.parent for path in (CHECKOUT / folder).rglob(f"*.{ending}") if path.name != "__init__.py")
    assert max(files.values()) <= MOST_FILES, files.most_common(1)


def test_every_file_is_in_a_package() -> None:
    for name in MODULES:
        assert name.rpartition(".")[0] in {*PACKAGES, ""}, name
