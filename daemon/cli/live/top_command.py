"""`top`: the rig at a glance in a terminal."""

from __future__ import annotations

import argparse


def options(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(run_command=_top)


def _top(arguments: argparse.Namespace) -> int:
    import asyncio

    from config.errors import EXIT_REFUSED
    from daemon.live.terminal.screen import show_top
    from daemon.processes.paths import socket_path

    return 0 if asyncio.run(show_top(str(socket_path(arguments.socket)))) else EXIT_REFUSED
