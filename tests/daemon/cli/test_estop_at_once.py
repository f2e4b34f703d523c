"""A bare `longreach estop` leaves before parsers are loaded; where its answer is not the expected one, the usual command asks again."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from config.errors import DaemonError
from daemon.cli.estop_at_once import OUTPUTS_SAFE
from daemon.cli.main import main
from daemon.server.protocol import error_line, parse_request, result_line

LOADED = f"""
import sys
sys.path.insert(0, {str(Path.cwd())!r})
from daemon.cli.main import main
status = main(sys.argv[1:])
print([name for name in ("argparse", "dataclasses", "pathlib", "json", "daemon.cli.command_line") if name in sys.modules], file=sys.stderr)
sys.exit(status)
"""


@contextmanager
def daemon_that_answers(path: Path, *answers: str) -> Iterator[list[str]]:
    """One connection for each of `answers`: "done", "refused" or "silent"; yields the methods that it was asked for."""
    asked: list[str] = []
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(str(path))
    listener.listen()

    def serve() -> None:
        for answer in answers:
            connection, _ = listener.accept()
            with connection, connection.makefile("rwb") as stream:
                if answer == "silent":
                    stream.readline()
                    continue
                for line in stream:
                    request = parse_request(line)
                    asked.append(request.method)
                    refused = error_line(request.id, DaemonError("not now"))
                    stream.write(result_line(request.id, {"mode": "fault"}) if answer == "done" else refused)
                    stream.flush()

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield asked
    finally:
        thread.join(10)
        listener.close()


def test_nothing_but_the_socket_is_loaded(tmp_path: Path) -> None:
    path = tmp_path / "s"
    with daemon_that_answers(path, "done") as asked:
        words = [
            sys.executable,
            "-S",
            "-c",
            f"import sys; sys.path.insert(0, {str(Path.cwd())!r})\n{LOADED}",
            "--socket",
            str(path),
            "estop",
        ]
        found = subprocess.run(words, capture_output=True, text=True, check=True)
    assert asked == ["estop"]
    assert found.stdout == f"{OUTPUTS_SAFE}\n"
    assert found.stderr == "['pathlib']\n"  # for the socket's place


@pytest.mark.parametrize("first", ["refused", "silent"])
def test_the_usual_command_asks_again(first: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with daemon_that_answers(tmp_path / "s", first, "done") as asked:
        assert main(["--socket", str(tmp_path / "s"), "estop"]) == 0
    assert asked[-1] == "estop"
    assert capsys.readouterr().out == f"{OUTPUTS_SAFE}\n"


@pytest.mark.parametrize("verb", ["estop", "stop"])
def test_where_nobody_answers_the_hardware_e_stop_is_what_is_left(verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--socket", str(tmp_path / "none"), verb]) == 1
    said = capsys.readouterr().err
    assert f"the {'e-stop' if verb == 'estop' else 'stop'} was NOT delivered" in said
    assert "Press the hardware e-stop, or shut off the hydraulic pressure." in said
    assert said.endswith("next: longreach status\n")


@pytest.mark.parametrize("verb", ["estop", "stop"])
def test_a_daemon_that_hangs_is_told_in_seconds(
    verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("daemon.cli.estop_at_once._PATIENCE_S", 0.05)
    monkeypatch.setattr("daemon.cli.connection.STOP_PATIENCE_S", 0.05)
    with socket.socket(socket.AF_UNIX) as hangs:
        hangs.bind(str(tmp_path / "s"))
        hangs.listen()
        assert main(["--socket", str(tmp_path / "s"), verb]) == 1
    assert "was NOT delivered: timed out" in capsys.readouterr().err


def test_other_words_go_the_usual_way(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with daemon_that_answers(tmp_path / "s", "done"):
        assert main(["--socket", str(tmp_path / "s"), "estop", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"mode": "fault"}
    with pytest.raises(SystemExit):
        main(["estop", "--help"])
