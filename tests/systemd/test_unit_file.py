"""The systemd unit, judged by systemd itself."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

UNIT = Path(__file__).resolve().parents[2] / "systemd" / "longreachd.service"

pytestmark = pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")


def analyze(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["systemd-analyze", *arguments, str(UNIT)], capture_output=True, text=True, timeout=60, check=False)


def test_systemd_accepts_every_line() -> None:
    """An unknown key or a bad value is only a message on stderr (exit status 0), so stderr must be empty."""
    answer = analyze("verify")
    assert answer.returncode == 0
    assert answer.stderr == ""


def test_sandbox_exposure_is_small() -> None:
    """Threshold in tenths: 25 is 2.5; systemd-analyze exits with 1 above it."""
    answer = analyze("security", "--offline=true", "--threshold=25")
    assert answer.returncode == 0, answer.stdout[-400:]


def settings() -> dict[str, str]:
    lines = (line.strip() for line in UNIT.read_text(encoding="utf-8").splitlines())
    return dict(line.split("=", 1) for line in lines if "=" in line and not line.startswith("#"))


def test_real_time_is_possible() -> None:
    """RestrictRealtime= in a copied hardening list would silently take SCHED_FIFO away."""
    unit = settings()
    assert "RestrictRealtime" not in unit
    assert unit["LimitRTPRIO"] == "99"
    assert unit["LimitMEMLOCK"] == "infinity"


def test_stop_is_asked_once_and_given_time() -> None:
    unit = settings()
    assert unit["KillSignal"] == "SIGTERM"
    assert unit["KillMode"] == "control-group"  # mixed would leave a hung loop alive while ExecStopPost= runs
    assert float(unit["TimeoutStopSec"]) >= 5.0
