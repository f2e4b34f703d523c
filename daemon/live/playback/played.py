"""A log that is played, as a socket: served until interrupted, or by a thread while something else looks."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from config.errors import LongreachError
from daemon.live.playback.log_methods import LogMethods
from daemon.live.playback.log_player import LogPlayer
from daemon.server.socket_server import serving

_END_S = 5.0


async def serve_played(player: LogPlayer, socket: Path, ended: asyncio.Event, ready: Callable[[], None]) -> None:
    """Until `ended`; `ready` is called once views can connect. DaemonError when the socket cannot be made."""
    async with serving(socket, None, LogMethods(player).methods):
        ready()
        await ended.wait()


@contextmanager
def played(player: LogPlayer, socket: Path) -> Iterator[None]:
    """Served meanwhile. Raises what `serve_played` raises before views can connect."""
    loop, begun, refused = asyncio.new_event_loop(), threading.Event(), []
    ended = asyncio.Event()

    def run() -> None:
        try:
            loop.run_until_complete(serve_played(player, socket, ended, begun.set))
        except LongreachError as error:
            refused.append(error)
            begun.set()

    server = threading.Thread(target=run, daemon=True)
    server.start()
    begun.wait()
    if refused:
        raise refused[0]
    try:
        yield
    finally:
        loop.call_soon_threadsafe(ended.set)
        server.join(_END_S)
