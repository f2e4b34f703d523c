"""How a command reaches the daemon: the socket's place and options every such command shares."""

from __future__ import annotations

import argparse
import json
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any

from config.errors import DaemonError, LongreachError
from config.stated_sentences import StatedSentences, sentences_from
from daemon.processes.paths import socket_path
from daemon.server.protocol import DEFAULT_TIMEOUT_S, Client

STOP_PATIENCE_S = 6.0  # the daemon itself waits 5 s for the loop
BY_HAND = "Press the hardware e-stop, or shut off the hydraulic pressure. Then `longreach status`: does a daemon run?"


class OperatorClient(Client):
    """A connection whose refusals come in the units of the rig file, unless `si`."""

    def __init__(self, path: str | PathLike[str], si: bool, timeout_s: float = DEFAULT_TIMEOUT_S) -> None:
        super().__init__(path, timeout_s)
        self._sentences: StatedSentences | None = StatedSentences({}) if si else None

    def __enter__(self) -> OperatorClient:
        return self

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        try:
            return super().call(method, **params)
        except LongreachError as error:
            if error.__cause__ is not None:  # nobody answers
                raise
            raise self.sentences().refusal(error) from error

    def sentences(self) -> StatedSentences:
        """What puts the daemon's sentences into the units of the rig file. Asked once."""
        if self._sentences is None:
            self._sentences = StatedSentences({})
            with suppress(LongreachError):
                self._sentences = sentences_from(super().call("units"))
        return self._sentences


def add_json_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON for scripts")


def daemon_socket(arguments: argparse.Namespace) -> Path:
    """Where the daemon listens, for a command that asks it: `asks_daemon` from now on."""
    arguments.asked_daemon = True
    return socket_path(arguments.socket)


def asks_daemon(arguments: argparse.Namespace) -> bool:
    """Whether the command has to do with a daemon, which goes on when the command is interrupted."""
    return getattr(arguments, "asked_daemon", False)


def connect(arguments: argparse.Namespace) -> OperatorClient:
    """A client on the daemon's socket; DaemonError with what to do when nobody answers. `--si` and `--json` are SI."""
    return OperatorClient(daemon_socket(arguments), si=getattr(arguments, "si", False) or getattr(arguments, "json", False))


def ask(arguments: argparse.Namespace, method: str, **params: Any) -> dict[str, Any]:
    """One request, one answer."""
    with connect(arguments) as client:
        return client.call(method, **params)


def ask_to_stop(arguments: argparse.Namespace, method: str, name: str) -> dict[str, Any]:
    """A request that somebody beside a moving arm waits for: when nobody answers soon, what is left to do is said at once."""
    try:
        with OperatorClient(daemon_socket(arguments), si=arguments.json, timeout_s=STOP_PATIENCE_S) as client:
            return client.call(method)
    except DaemonError as error:
        if error.__cause__ is None:  # the daemon's own refusal
            raise
        raise DaemonError(
            f"the {name} was NOT delivered", value=error.refusal.value, where=error.refusal.where, next_step=BY_HAND
        ) from error


def show(arguments: argparse.Namespace, answer: dict[str, Any], text: str) -> None:
    """Print the answer as JSON or as the given sentence."""
    print(json.dumps(answer) if arguments.json else text)
