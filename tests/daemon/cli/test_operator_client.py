"""The connection of a command: refusals come in the units of the rig file, and in SI for --si and --json."""

from __future__ import annotations

import argparse
import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from config.errors import DaemonError, ManeuverError
from daemon.cli.connection import connect

SENTENCES = {"sentences": {"prismatic": {"m": ["in", 1 / 0.0254, 0.0]}}, "units": {}}
REFUSAL = {"class": "ManeuverError", "what": "prismatic is at 0.9144 m", "value": "0.0254", "unit": "m", "next_step": "`longreach stop`"}


@contextmanager
def refusing_daemon(path: Path, knows_units: bool = True) -> Iterator[list[str]]:
    """Answers `units`, refuses everything else; yields the methods it was asked for."""
    asked: list[str] = []
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(str(path))
    listener.listen()

    def serve() -> None:
        connection, _ = listener.accept()
        with connection, connection.makefile("rwb") as stream:
            for line in stream:
                request = json.loads(line)
                asked.append(request["method"])
                units = request["method"] == "units" and knows_units
                answer = {"id": request["id"], **({"result": SENTENCES} if units else {"error": REFUSAL})}
                stream.write(json.dumps(answer).encode() + b"\n")
                stream.flush()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    yield asked
    thread.join(5)
    listener.close()


def options(path: Path, **flags: bool) -> argparse.Namespace:
    return argparse.Namespace(socket=str(path), **flags)


def test_a_refusal_is_put_into_the_units_of_the_rig_file(tmp_path: Path) -> None:
    with refusing_daemon(tmp_path / "s") as asked, connect(options(tmp_path / "s")) as client:
        with pytest.raises(ManeuverError, match=r"prismatic is at 36 in: 1 in\. `longreach stop`"):
            client.call("start")
        with pytest.raises(ManeuverError, match="36 in"):
            client.call("start")
    assert asked == ["start", "units", "start"]  # the units are asked for once


@pytest.mark.parametrize("flag", ["si", "json"])
def test_si_and_scripts_get_it_as_the_daemon_says_it(tmp_path: Path, flag: str) -> None:
    said = pytest.raises(ManeuverError, match=r"prismatic is at 0\.9144 m: 0\.0254 m")
    with refusing_daemon(tmp_path / "s") as asked, connect(options(tmp_path / "s", **{flag: True})) as client, said:
        client.call("start")
    assert asked == ["start"]


def test_a_daemon_that_does_not_know_units_is_quoted(tmp_path: Path) -> None:
    said = pytest.raises(ManeuverError, match=r"0\.9144 m")
    with refusing_daemon(tmp_path / "s", knows_units=False), connect(options(tmp_path / "s")) as client, said:
        client.call("start")


def test_nobody_there_is_said_at_once(tmp_path: Path) -> None:
    with pytest.raises(DaemonError, match="no answer from the daemon"):
        connect(options(tmp_path / "none"))
