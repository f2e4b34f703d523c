"""The wheel in an environment that holds nothing but it and the libraries that it declares: every module imports, the notebooks run."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tests.support.system.built_wheel import CHECKOUT, built_wheel, environment_with

NOTEBOOKS = CHECKOUT / "docs" / "guide" / "notebooks"
OWN = {"drive", "frame"}  # needs a daemon; needs pandas, which is an extra
LONG = {"design", "find_gap"}  # searches; find_gap runs in test_wheel
MODULES = """
import importlib, pkgutil, sysconfig
from importlib.metadata import files
place = sysconfig.get_path("purelib")
own = sorted({file.parts[0] for file in files("longreach") if file.name == "__init__.py" and len(file.parts) == 2})
names = [found.name for top in own for found in pkgutil.walk_packages([f"{place}/{top}"], f"{top}.")]
for name in names:
    if not name.endswith(("__main__", "driver_contract")):  # the latter is for pytest, of who writes a driver
        importlib.import_module(name)
print(len(names), importlib.import_module("config").__file__)
"""
CELLS = """
import json, os, sys
for name, text in json.load(sys.stdin).items():
    os.mkdir(name)
    os.chdir(name)
    print(name, flush=True)
    exec(compile(text, name, "exec"), {"__name__": "__main__"})
    os.chdir("..")
"""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of such an environment."""
    folder = tmp_path_factory.mktemp("alone")
    return environment_with(built_wheel(folder), folder / "environment")


def test_every_module_imports_with_the_declared_libraries(alone: Path, tmp_path: Path) -> None:
    done = subprocess.run([alone, "-I", "-c", MODULES], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    count, where = done.stdout.split()
    assert int(count) > 500
    assert where.startswith(str(alone.parents[1]))


def test_the_notebooks_run_with_the_declared_libraries(alone: Path, tmp_path: Path) -> None:
    pages = {path.stem: json.loads(path.read_text()) for path in sorted(NOTEBOOKS.glob("*.ipynb")) if path.stem not in OWN | LONG}
    cells = {
        name: "\n".join("".join(cell["source"]) for cell in page["cells"] if cell["cell_type"] == "code") for name, page in pages.items()
    }
    done = subprocess.run([alone, "-I", "-c", CELLS], cwd=tmp_path, input=json.dumps(cells), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert {line for line in done.stdout.splitlines() if line in cells} == set(cells)
