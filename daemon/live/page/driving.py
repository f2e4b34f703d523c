"""Hold-to-move in the page: one window's set points, word for word those of the socket, over one connection to the daemon.

The window that asked for a run owns it. When it closes, the connection does, and the arm stops; when the browser or the network
hangs, no set point comes and the daemon's time-out stops it.
"""

from __future__ import annotations

import json
from contextlib import suppress
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from config.errors import DaemonError, LongreachError
from daemon.live.source.connection import Connection
from daemon.server.protocol import encode

MAY = {
    "stream": {"shaper", "countdown_s", "settle_s"},
    "set_point": {"run", "rate", "target", "tip_mps", "end", "t_s"},
}
ANSWER_S = 20.0  # a run that waits for rest


async def drive(window: WebSocket, socket: str) -> None:
    """Until the window leaves. Whatever it sends is answered with the daemon's result or refusal."""
    connection = Connection(socket)
    try:
        with suppress(WebSocketDisconnect, KeyError):  # KeyError: bytes where text belongs
            while True:
                await window.send_text(encode(await _answer(connection, await window.receive_text())).decode())
    finally:
        connection.close()


async def _answer(connection: Connection, text: str) -> dict[str, Any]:
    try:
        method, params = _asked(text)
        return {"method": method, "result": await connection.call(method, params, ANSWER_S)}
    except LongreachError as error:
        return {"error": {"class": type(error).__name__, **error.refusal.as_dict()}}


def _asked(text: str) -> tuple[str, dict[str, Any]]:
    """Method and parameters. DaemonError for anything that is no request of this kind."""
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DaemonError("what the page sent is no JSON", value=text[:80]) from error
    method, params = (content.get("method"), content.get("params", {})) if isinstance(content, dict) else (None, {})
    if method not in MAY or not isinstance(params, dict) or not set(params) <= MAY[method]:
        raise DaemonError("no request for driving by hand", value=text[:80], limit=", ".join(MAY))
    return method, params
