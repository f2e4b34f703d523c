"""How a command reaches the daemon: the socket's place and options every such command shares."""

from __future__ import annotations

import argparse
import json
from typing import Any

from daemon.places import socket_path
from daemon.protocol import Client


def add_json_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON for scripts")


def connect(arguments: argparse.Namespace) -> Client:
    """A client on the daemon's socket; DaemonError with what to do when nobody answers."""
    return Client(socket_path(arguments.socket))


def ask(arguments: argparse.Namespace, method: str, **params: Any) -> dict[str, Any]:
    """One request, one answer."""
    with connect(arguments) as client:
        return client.call(method, **params)


def show(arguments: argparse.Namespace, answer: dict[str, Any], text: str) -> None:
    """Print the answer as JSON or as the given sentence."""
    print(json.dumps(answer) if arguments.json else text)
