"""How a command reaches the daemon: the socket's place and options every such command shares."""

from __future__ import annotations

import argparse
import json
from contextlib import suppress
from os import PathLike
from typing import Any

from config.errors import LongreachError
from config.stated_sentences import StatedSentences, sentences_from
from daemon.processes.paths import socket_path
from daemon.server.protocol import Client


class OperatorClient(Client):
    """A connection whose refusals come in the units of the rig file, unless `si`."""

    def __init__(self, path: str | PathLike[str], si: bool) -> None:
        super().__init__(path)
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


def connect(arguments: argparse.Namespace) -> OperatorClient:
    """A client on the daemon's socket; DaemonError with what to do when nobody answers. `--si` and `--json` are SI."""
    return OperatorClient(socket_path(arguments.socket), si=getattr(arguments, "si", False) or getattr(arguments, "json", False))


def ask(arguments: argparse.Namespace, method: str, **params: Any) -> dict[str, Any]:
    """One request, one answer."""
    with connect(arguments) as client:
        return client.call(method, **params)


def show(arguments: argparse.Namespace, answer: dict[str, Any], text: str) -> None:
    """Print the answer as JSON or as the given sentence."""
    print(json.dumps(answer) if arguments.json else text)
