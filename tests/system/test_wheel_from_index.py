"""The wheel as a user gets it: an empty environment, pip, and the libraries that the package index has today."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.system.built_wheel import CHECKOUT, PIP, built_wheel

PATIENCE = ["--timeout", "15", "--retries", "1"]

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]


@pytest.fixture(scope="module")
def bin_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("index")
    asked = [*PIP, "download", *PATIENCE, "--no-deps", "--dest", str(folder / "asked"), "packaging"]
    answer = subprocess.run(asked, capture_output=True, text=True, check=False)
    if answer.returncode != 0:
        pytest.skip(f"no package index here: {answer.stderr.strip().splitlines()[-1]}")
    environment = folder / "environment"
    subprocess.run([sys.executable, "-m", "venv", str(environment)], check=True)
    pip = [environment / "bin" / "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", *PATIENCE, str(built_wheel(folder))], check=True)
    return environment / "bin"


def run(command: Path, *words: str, folder: Path) -> str:
    done = subprocess.run([command, *words], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_nothing_that_was_installed_asks_for_something_missing(bin_folder: Path, tmp_path: Path) -> None:
    run(bin_folder / "pip", "check", folder=tmp_path)


def test_a_user_checks_a_rig_runs_it_and_gets_its_page(bin_folder: Path, tmp_path: Path) -> None:
    longreach = bin_folder / "longreach"
    assert json.loads(run(longreach, "version", "--json", folder=tmp_path))["software_version"]
    run(longreach, "check", "ornl_testbed", folder=tmp_path)
    run(longreach, "simulate", "ornl_testbed", "paper_line", "--shaper", "adaptive", "-o", "a.mcap", folder=tmp_path)
    run(longreach, "log", "report", "a.mcap", "--no-simulation", folder=tmp_path)
    assert (tmp_path / "a-run-1.html").stat().st_size > 100_000


def test_an_axis_is_searched_for_what_its_model_lacks(bin_folder: Path, tmp_path: Path) -> None:
    notebook = json.loads((CHECKOUT / "docs/guide/notebooks/find_gap.ipynb").read_text())
    code = "".join(line for cell in notebook["cells"] if cell["cell_type"] == "code" for line in cell["source"])
    assert "('coulomb_friction', 'axis')" in run(bin_folder / "python", "-c", code, folder=tmp_path)
