"""The wheel, installed away from the checkout, finds its rigs, maneuvers and pages and runs the simulated arm."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.daemon.running_daemon import RunningDaemon
from tests.support.live.page_server import page_server
from tests.support.system.built_wheel import CHECKOUT, PIP, built_wheel

HOUSE = ("config", "servo_control", "daemon", "drivers", "gap", "longreach", "recording", "sim_backend", "tuning")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with nothing but the wheel's content; the libraries are this environment's."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run([*PIP, "install", "--no-deps", "--target", str(folder / "site"), str(built_wheel(folder))], check=True)
    return folder / "site"


def run(installed: Path, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "daemon.cli.main", *words]
    return subprocess.run(command, cwd=folder, env=os.environ | {"PYTHONPATH": str(installed)}, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_check_simulate_and_version_away_from_the_checkout(installed: Path, tmp_path: Path) -> None:
    where = subprocess.run(
        [sys.executable, "-c", "import config, gap; print(config.__file__)"], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(installed)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert str(installed) in where.stdout
    assert run(installed, tmp_path, "check", "ornl_testbed").returncode == 0
    done = run(installed, tmp_path, "simulate", "ornl_testbed", "paper_line", "--shaper", "adaptive", "-o", "a.mcap")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a.mcap").stat().st_size > 100_000
    page = run(installed, tmp_path, "log", "report", "a.mcap", "--no-simulation")
    assert page.returncode == 0, page.stderr
    assert (tmp_path / "a-run-1.html").stat().st_size > 100_000
    facts = json.loads(run(installed, tmp_path, "version", "--json").stdout)
    assert facts["software_version"]
    assert facts["libraries"]["numpy"] != "not installed"


@pytest.fixture
def as_a_user(installed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Every process that a test starts runs the wheel, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(installed))
    return tmp_path


@pytest.mark.slow
def test_the_demo_makes_its_table_and_pictures(installed: Path, as_a_user: Path) -> None:
    done = run(installed, as_a_user, "demo", "--lockstep", "--out", "demo")
    assert done.returncode == 0, done.stderr
    assert "adaptive" in done.stdout
    assert list((as_a_user / "demo").glob("*.png"))


@pytest.mark.slow
@pytest.mark.clock
def test_the_page_is_served_beside_a_daemon_of_the_wheel(installed: Path, as_a_user: Path) -> None:
    with RunningDaemon(as_a_user) as daemon:
        daemon.wait_until_ready().close()
        with page_server(daemon.socket, as_a_user) as page:
            assert str(installed) in Path(f"/proc/{page.pid}/environ").read_text(errors="replace")
            for name in ("/", "/static/app.js", "/static/uplot/uPlot.iife.min.js"):
                assert page.send("GET", name)[0] == 200, name
            assert page.ask("status")[1]["mode"] == "disarmed"


@pytest.mark.slow
def test_the_twin_comes_up_and_ends_when_asked(installed: Path, as_a_user: Path) -> None:
    words = ["twin", "ornl_testbed_can", "--interface", "virtual", "--priority", "0", "--quiet"]
    twin = subprocess.Popen([sys.executable, "-m", "daemon.cli.main", *words], stdout=subprocess.PIPE, text=True)
    try:
        assert twin.stdout is not None
        assert twin.stdout.readline().startswith("twin of ornl_testbed_can: ")
    finally:
        twin.terminate()
    assert twin.communicate(timeout=30)[0].strip().endswith("twin: stopped")
    assert twin.returncode == 0


@pytest.mark.slow
def test_a_gap_is_searched_for_to_its_report(installed: Path, as_a_user: Path) -> None:
    """The notebook of `find_gap`, as it stands in the guide."""
    notebook = json.loads((CHECKOUT / "docs" / "guide" / "notebooks" / "find_gap.ipynb").read_text())
    code = "".join(line for cell in notebook["cells"] if cell["cell_type"] == "code" for line in cell["source"])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "('coulomb_friction', 'axis')" in done.stdout
    assert (as_a_user / "found" / "report.html").stat().st_size > 10_000


@pytest.mark.slow
def test_every_file_of_data_is_in_the_wheel(installed: Path) -> None:
    """Rigs, maneuvers, maps, pages: whatever stands beside the code."""
    tracked = subprocess.run(["git", "ls-files", "-z", "--", *HOUSE], cwd=CHECKOUT, capture_output=True, text=True, check=True).stdout
    data = [name for name in tracked.split("\0") if name and not name.endswith(".py")]
    assert len(data) > 20
    assert [name for name in data if not (installed / name).is_file()] == []
