"""A daemon whose start ends before it serves: a rig that cannot be used, a signal at any moment."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path

import pytest

from config.errors import EXIT_INTERRUPTED, EXIT_REFUSED, EXIT_USAGE
from daemon.processes import supervisor
from tests.support.daemon.running_daemon import RunningDaemon, until

pytestmark = pytest.mark.clock


def test_a_rig_that_cannot_be_used_ends_the_start_with_the_reason(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path, rig="no_such_rig") as daemon:
        assert daemon.process.wait(30) == 1
        assert "ornl_testbed" in daemon.text()


def test_told_to_end_while_it_starts_it_ends_and_claims_no_mode(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as starting:
        until(lambda: catches(starting.process.pid, signal.SIGTERM))
        assert "is disarmed" not in starting.text()
        starting.process.send_signal(signal.SIGTERM)
        assert starting.process.wait(120) == 0
        assert "was told to end while it started; its outputs stayed safe" in starting.text()
        assert "is disarmed" not in starting.text()
        assert not starting.socket.exists()


def test_ctrl_c_at_its_first_words_ends_it_in_order(tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as starting:
        until(lambda: "host grade" in starting.text())
        starting.process.send_signal(signal.SIGINT)
        assert starting.process.wait(120) == 0
        assert "Traceback" not in starting.text()


def test_ctrl_c_before_anything_was_started_is_one_sentence(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(arguments: argparse.Namespace) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(supervisor, "_run", interrupted)
    assert supervisor.main(["ornl_testbed"]) == EXIT_INTERRUPTED
    assert capsys.readouterr().err == "longreachd: ended by Ctrl-C before anything was started\n"


def catches(pid: int, number: signal.Signals) -> bool:
    """As the kernel has it: before, the signal would end the process."""
    status = Path(f"/proc/{pid}/status").read_text()
    caught = next(int(line.split()[1], 16) for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(caught >> (number - 1) & 1)


def test_words_that_fit_nothing_and_a_name_of_ones_own_get_a_next_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as refused:
        supervisor.main(["--foo"])
    assert refused.value.code == EXIT_USAGE
    assert capsys.readouterr().err.endswith("\nnext: longreachd --help\n")
    Path("my_rig.yaml").touch()
    assert supervisor.main(["my_rig"]) == EXIT_REFUSED
    assert capsys.readouterr().err.endswith("\nnext: longreachd my_rig.yaml\n")
