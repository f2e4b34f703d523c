"""The process of `longreach live`: feeds the SDK's server on loopback until it is interrupted."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from foxglove import Context, start_server
from foxglove.websocket import WebSocketServer

from config.errors import DaemonError
from config.whole_file import whole_file
from daemon.live.foxglove.topics import Topics, layout_of
from daemon.live.source.feed import Feed
from daemon.live.source.pending import Content

LOOPBACK = "127.0.0.1"
BACKLOG = 256  # messages that a client may be behind: 5 s

Say = Callable[[str], None]


async def serve_foxglove(socket: str, port: int, layout: Path | None, say: Say) -> None:
    """`port` 0: any free one. `layout`: where the layout for the rig is written. DaemonError when the port cannot be had."""
    feed, live = Feed(socket), _Live(port, layout, say)
    feeding, sending = asyncio.create_task(feed.run()), asyncio.create_task(_send(feed, live))
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, sending.cancel)
    try:
        with suppress(asyncio.CancelledError):
            await sending
    finally:
        feeding.cancel()
        if live.server is not None:
            live.server.stop()


async def _send(feed: Feed, live: _Live) -> None:
    with feed.watched() as pending:
        while True:
            live.take(await pending.take())


@dataclass(slots=True)
class _Live:
    """The server begins with the first rig: topics that come later may be subscribed to before the SDK knows them itself."""

    port: int
    layout: Path | None
    say: Say
    server: WebSocketServer | None = None
    _context: Context = field(default_factory=Context)
    _rig_text: str = ""
    _topics: Topics | None = None
    _lost: str = ""

    def take(self, content: Content) -> None:
        lost = content.get("lost", self._lost)
        if lost and lost != self._lost:  # the feed asks again twice a second; once is enough to say
            self.say(lost)
        self._lost = lost
        if "rig" in content and content["rig"]["text"] != self._rig_text:
            self._begin(content["rig"])
        if self._topics is not None:
            self._topics.send(content)

    def _begin(self, rig: dict[str, Any]) -> None:
        if self._topics is not None:
            self._topics.close()
        self._rig_text, self._topics = rig["text"], Topics(rig, self._context)
        if self.layout is not None:
            with whole_file(self.layout, "layout") as temporary:
                temporary.write_bytes(layout_of(rig))
        if self.server is None:
            self.server = _server(self.port, self._context)
            self.say(f"ws://{LOOPBACK}:{self.server.port}")


def _server(port: int, context: Context) -> WebSocketServer:
    try:
        return start_server(name="longreach", host=LOOPBACK, port=port, context=context, message_backlog_size=BACKLOG)
    except RuntimeError as error:
        advice = "Is another `longreach live` running? Give another --port, or --port 0 for any free one."
        mend = {"--port": "0"}
        raise DaemonError("the port cannot be had", value=str(error), where=f"port {port}", next_step=advice, mend=mend) from error
