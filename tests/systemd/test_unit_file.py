"""The systemd units, judged by systemd itself."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "daemon" / "systemd"
DAEMON, REPORTS = FOLDER / "longreachd.service", FOLDER / "longreach-reports.service"
EXPOSURE = {DAEMON: 25, REPORTS: 6}  # in tenths; systemd-analyze exits with 1 above it

with_systemd = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")
both = pytest.mark.parametrize("unit", [DAEMON, REPORTS], ids=lambda unit: unit.stem)


def analyze(unit: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["systemd-analyze", *arguments, str(unit)], capture_output=True, text=True, timeout=60, check=False)


@with_systemd
@both
def test_systemd_accepts_every_line(unit: Path) -> None:
    """An unknown key or a bad value is only a message on stderr (exit status 0), so stderr must be empty."""
    answer = analyze(unit, "verify")
    assert answer.returncode == 0
    assert answer.stderr == ""


@with_systemd
@both
def test_sandbox_exposure_is_small(unit: Path) -> None:
    answer = analyze(unit, "security", "--offline=true", f"--threshold={EXPOSURE[unit]}")
    assert answer.returncode == 0, answer.stdout[-400:]


def settings(unit: Path) -> dict[str, str]:
    lines = (line.strip() for line in unit.read_text(encoding="utf-8").splitlines())
    return dict(line.split("=", 1) for line in lines if "=" in line and not line.startswith("#"))


def test_real_time_is_possible() -> None:
    """RestrictRealtime= in a copied hardening list would silently take SCHED_FIFO away."""
    unit = settings(DAEMON)
    assert "RestrictRealtime" not in unit
    assert unit["LimitRTPRIO"] == "99"
    assert unit["LimitMEMLOCK"] == "infinity"


def test_stop_is_asked_once_and_given_time() -> None:
    unit = settings(DAEMON)
    assert unit["KillSignal"] == "SIGTERM"
    assert unit["KillMode"] == "control-group"  # mixed would leave a hung loop alive while ExecStopPost= runs
    assert float(unit["TimeoutStopSec"]) >= 5.0


def test_pages_are_made_with_what_is_left_over() -> None:
    unit, daemon = settings(REPORTS), settings(DAEMON)
    assert (unit["Nice"], unit["CPUSchedulingPolicy"], unit["IOSchedulingClass"]) == ("19", "idle", "idle")
    assert int(unit["OOMScoreAdjust"]) > 0 > int(daemon["OOMScoreAdjust"])
    assert {unit[key] == daemon[key] for key in ("User", "Group", "LogsDirectory", "LogsDirectoryMode", "UMask")} == {True}
    assert unit["ExecStart"].endswith("longreach log report --all %L/longreach --watch")
