"""What no command is asked about: a terminal of few characters, an output that takes nothing, an interrupt, an error of our own."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from config.errors import EXIT_INTERRUPTED
from daemon.cli import command_line
from daemon.cli.main import main


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_without_a_character_shows_a_question_mark(encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding=encoding))
    monkeypatch.setattr("daemon.cli.operate.version_command._version", lambda _: print("1 → 2") or 0)
    assert main(["version"]) == 0
    assert written.getvalue().splitlines()[0] == b"1 ? 2"


def raising(error: BaseException) -> object:
    def command(_: object) -> int:
        raise error

    return command


def test_an_error_nobody_foresaw_is_one_sentence_to_report(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("daemon.cli.operate.version_command._version", raising(ZeroDivisionError("by 0")))
    assert main(["version"]) == 1
    said = capsys.readouterr().err.splitlines()
    assert f"{__file__}:" in said[0]
    assert "internal error of longreach: ZeroDivisionError: by 0. Please report this" in said[0]
    assert said[1:] == ["next: longreach version"]
    monkeypatch.setenv(command_line.TRACEBACK, "1")
    with pytest.raises(ZeroDivisionError):
        main(["version"])


@pytest.mark.parametrize("words", [["check", "nowhere", "--json"], ["version", "--json"], ["version"]])
def test_a_full_disk_is_told_on_stderr(words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with Path("/dev/full").open("w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert main(words) == 1
        monkeypatch.undo()
    said = capsys.readouterr().err
    assert ("nowhere" if "nowhere" in words else "The disk is full") in said


def test_only_a_command_that_asked_the_daemon_says_that_it_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("daemon.cli.operate.version_command._version", raising(KeyboardInterrupt()))
    monkeypatch.setattr("daemon.cli.connection.OperatorClient", raising_client)
    assert main(["version"]) == EXIT_INTERRUPTED
    assert capsys.readouterr().err == "interrupted\n"
    for name in ("status", "stop"):
        assert main([name]) == EXIT_INTERRUPTED
        assert "the daemon goes on" in capsys.readouterr().err


def raising_client(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_an_interrupt_before_the_words_are_read_is_no_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command_line, "build_parser", raising_client)
    assert main(["version"]) == EXIT_INTERRUPTED


def test_python_runs_the_package_too() -> None:
    ran = subprocess.run([sys.executable, "-m", "longreach", "version", "--json"], capture_output=True, text=True, check=True)
    assert "software_version" in json.loads(ran.stdout)


def signalled(*numbers: int, rest: Callable[[], None] = lambda: None) -> object:
    """A command that gets a signal and, while it brings things to rest, the others."""

    def command(_: object) -> int:
        try:
            os.kill(os.getpid(), numbers[0])
            time.sleep(60)
        except KeyboardInterrupt:
            for number in numbers[1:]:
                os.kill(os.getpid(), number)
            rest()
            raise
        return 0

    return command


@pytest.mark.usefixtures("terminal_can_end")
@pytest.mark.parametrize("numbers", [(signal.SIGTERM,), (signal.SIGHUP, signal.SIGTERM, signal.SIGHUP)])
def test_a_signal_that_ends_programs_is_an_interrupt_that_a_second_one_does_not_cut_short(
    numbers: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    rested: list[str] = []
    command = signalled(*numbers, rest=lambda: rested.append("at rest"))
    monkeypatch.setattr("daemon.cli.operate.version_command._version", command)
    assert main(["version"]) == 128 + numbers[0]
    assert rested == ["at rest"]
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_what_nohup_ignores_stays_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "sleep", lambda _: None)
    monkeypatch.setattr("daemon.cli.operate.version_command._version", signalled(signal.SIGHUP))
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert main(["version"]) == 0
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
