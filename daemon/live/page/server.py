"""The process of `longreach ui`: one server on loopback until it is interrupted."""

from __future__ import annotations

import signal
import socket as sockets
from collections.abc import Callable

import uvicorn

from config.errors import DaemonError
from daemon.live.page.application import Page
from daemon.live.page.guard import Guard
from daemon.server.until_ctrl_c import until_ctrl_c

LOOPBACK = "127.0.0.1"
LONGEST_MESSAGE_BYTES = 64 << 10  # of a browser
SHUT_DOWN_S = 2


def serve_page(socket: str, token: str, port: int, control: bool, ready: Callable[[str], None]) -> None:
    """`socket`: the daemon's; `port` 0: any free one. `ready` gets the address with the token once a browser can open it.

    DaemonError when the port cannot be had.
    """
    listening = _listen(port)
    port = listening.getsockname()[1]
    page = Page(socket, Guard(token, port, control))
    config = uvicorn.Config(
        page.application(),
        log_level="warning",
        access_log=False,
        server_header=False,
        ws="websockets-sansio",
        ws_max_size=LONGEST_MESSAGE_BYTES,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=SHUT_DOWN_S,
    )
    ready(f"http://{LOOPBACK}:{port}/#token={token}")
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # the server knows SIGTERM, and not the end of its terminal
        signal.signal(signal.SIGHUP, lambda *_: signal.raise_signal(signal.SIGTERM))
    until_ctrl_c(uvicorn.Server(config).serve(sockets=[listening]))


def _listen(port: int) -> sockets.socket:
    listening = sockets.socket(sockets.AF_INET, sockets.SOCK_STREAM)
    listening.setsockopt(sockets.SOL_SOCKET, sockets.SO_REUSEADDR, 1)
    try:
        listening.bind((LOOPBACK, port))
        listening.listen(64)
    except OSError as error:
        listening.close()
        advice = "Is another `longreach ui` running? Give another --port, or --port 0 for any free one."
        reason = error.strerror or str(error)
        raise DaemonError(
            "the page's port cannot be had", value=reason, where=f"port {port}", next_step=advice, mend={"--port": "0"}
        ) from error
    return listening
