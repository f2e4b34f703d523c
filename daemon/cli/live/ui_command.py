"""`ui`: the web page with live plots, checks, maneuvers and, with --control, the buttons."""

from __future__ import annotations

import argparse
import secrets
from pathlib import Path

from config.errors import DaemonError, UsageError
from daemon.cli.connection import daemon_socket
from daemon.cli.options.numbers import PORT

DEFAULT_PORT = 8042
SHORTEST_TOKEN = 16


def options(parser: argparse.ArgumentParser) -> None:
    port_help = "port on loopback (default %(default)s; 0: any free one)"
    parser.add_argument("--port", type=PORT, default=DEFAULT_PORT, metavar="N", help=port_help)
    parser.add_argument("--control", action="store_true", help="the page may also arm, start and stop; without it it only looks")
    parser.add_argument("--token-file", type=Path, metavar="FILE", help="take the token from this file (default: a new one every time)")
    parser.set_defaults(run_command=_ui)


def _ui(arguments: argparse.Namespace) -> int:
    from daemon.live.page.server import serve_page

    def ready(address: str) -> None:
        print(f"{'control' if arguments.control else 'read-only'}: {address}", flush=True)
        port = address.partition("/#")[0].rpartition(":")[2]
        print(f"from another computer: ssh -L {port}:127.0.0.1:{port} THIS-COMPUTER, then the same address", flush=True)

    serve_page(str(daemon_socket(arguments)), _token(arguments.token_file), arguments.port, arguments.control, ready)
    return 0


def _token(file: Path | None) -> str:
    """DaemonError for a file that others may read or that holds no token."""
    if file is None:
        return secrets.token_urlsafe(24)
    advice = f"Make one: (umask 077; openssl rand -hex 24 > {file})"
    if not file.is_file():
        raise UsageError("the token's file is none", where=str(file), next_step=advice)
    if file.stat().st_mode & 0o077:
        raise DaemonError("others may read the token", where=str(file), next_step=f"chmod 600 {file}")
    token = file.read_text(encoding="utf-8").strip()
    if len(token) < SHORTEST_TOKEN or not token.isascii() or not token.replace("-", "").replace("_", "").isalnum():
        limit = f"{SHORTEST_TOKEN} letters and digits at least"
        raise DaemonError("this is no token", value=f"{len(token)} characters", limit=limit, where=str(file), next_step=advice)
    return token
