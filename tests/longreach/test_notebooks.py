"""The notebooks of docs/guide/notebooks: one a public function, some ten lines, each run as it stands in a folder of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import longreach
from tests.support.daemon.running_daemon import RunningDaemon, arm

CHECKOUT = Path(__file__).parents[2]
NOTEBOOKS = CHECKOUT / "docs" / "guide" / "notebooks"
FUNCTIONS = sorted(name for name in longreach.__all__ if not isinstance(getattr(longreach, name), type))
MOST_LINES = 10
NEEDS = {"frame": "pandas"}
SLOW = {"find_gap", "design"}
ON_A_RIG = {"drive"}


def code(name: str) -> str:
    content: dict[str, Any] = json.loads((NOTEBOOKS / f"{name}.ipynb").read_text())
    return "\n".join("".join(cell["source"]) for cell in content["cells"] if cell["cell_type"] == "code")


def test_every_public_function_has_one_and_there_are_no_others() -> None:
    assert sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb")) == FUNCTIONS


@pytest.mark.parametrize("name", FUNCTIONS)
def test_it_is_short_uses_its_function_and_says_what_it_is(name: str) -> None:
    lines = [line for line in code(name).splitlines() if line.strip()]
    assert len(lines) <= MOST_LINES
    assert f"longreach.{name}(" in code(name)
    content = json.loads((NOTEBOOKS / f"{name}.ipynb").read_text())
    assert (content["nbformat"], content["nbformat_minor"]) == (4, 5)
    first, *rest = content["cells"]
    assert "".join(first["source"]).startswith(f"# `longreach.{name}`: ")
    assert [cell["outputs"] for cell in rest] == [[] for _ in rest], "results are made, not kept"


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in FUNCTIONS if name not in ON_A_RIG]
)
def test_it_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    monkeypatch.chdir(tmp_path)
    exec(compile(code(name), f"{name}.ipynb", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


@pytest.mark.slow
@pytest.mark.clock
def test_driving_by_hand_on_a_daemon(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with RunningDaemon(tmp_path) as daemon, daemon.wait_until_ready() as client:
        arm(client)
        monkeypatch.setenv("LONGREACH_SOCKET", str(daemon.socket))
        before = client.call("status")["joints"]["rotary"]["position"]
        exec(compile(code("drive"), "drive.ipynb", "exec"), {})
        assert "rate" in capsys.readouterr().out
        assert client.call("status")["joints"]["rotary"]["position"] - before == pytest.approx(0.05, abs=0.03)


@pytest.mark.slow
def test_the_gap_that_was_made_is_the_gap_that_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code("find_gap"), "find_gap.ipynb", "exec"), {})
    assert "('coulomb_friction', 'axis')" in capsys.readouterr().out
    found = json.loads((tmp_path / "found" / "findings.json").read_text())
    assert found["verdict"] == "named"
    assert found["gap"]["holdout_after"] < 1.2
