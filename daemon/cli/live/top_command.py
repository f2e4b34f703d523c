"""`top`: the rig at a glance in a terminal."""

from __future__ import annotations

import argparse

from daemon.cli.connection import daemon_socket


def options(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(run_command=_top)


def _top(arguments: argparse.Namespace) -> int:
    from config.errors import EXIT_REFUSED
    from daemon.live.terminal.screen import show_top
    from daemon.server.until_ctrl_c import until_ctrl_c

    return 0 if until_ctrl_c(show_top(str(daemon_socket(arguments)))) else EXIT_REFUSED
