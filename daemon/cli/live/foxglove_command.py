"""`live`: live data for Foxglove."""

from __future__ import annotations

import argparse

from daemon.cli.connection import daemon_socket
from daemon.cli.options.numbers import PORT
from daemon.cli.options.output_file import output_file

DEFAULT_PORT = 8765  # where Foxglove looks first


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--port", type=PORT, default=DEFAULT_PORT, metavar="N", help="port on loopback (default %(default)s; 0: any free one)"
    )
    parser.add_argument(
        "--layout", type=output_file(".json"), metavar="FILE.json", help="write the shipped layout for this rig there, to import it"
    )
    parser.set_defaults(run_command=_live)


def _live(arguments: argparse.Namespace) -> int:
    from daemon.live.foxglove.server import serve_foxglove
    from daemon.server.until_ctrl_c import until_ctrl_c

    def say(text: str) -> None:
        print(text, flush=True)

    until_ctrl_c(serve_foxglove(str(daemon_socket(arguments)), arguments.port, arguments.layout, say))
    return 0
