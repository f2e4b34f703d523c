"""The page's server: static files, live data over a WebSocket, requests. Everything but the static files needs the token."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from config.errors import LongreachError
from daemon.live.page.driving import drive
from daemon.live.page.guard import REPORT_POLICY, Guard, RequestError, with_headers
from daemon.live.page.maneuver_forms import maneuver_forms
from daemon.live.page.planning import Planning
from daemon.live.page.requests import ask_daemon, json_of
from daemon.live.page.runs import Runs
from daemon.live.source.connection import ask_once
from daemon.live.source.feed import Feed
from daemon.live.source.pending import Pending
from daemon.server.protocol import encode
from servo_control.shapers.shaper_choice import KINDS

STATIC = Path(__file__).parent / "static"
MOST_VIEWS = 16  # browser windows
AT_ONCE = ("estop", "stop", "disarm")  # what a window asks for past its other requests
AT_ONCE_LIMIT_S = 5.0
TOKEN_LIMIT_S = 5.0  # for a window to say who it is
REFUSED_CODE = 4401  # of a WebSocket that is closed for want of a token …
FULL_CODE = 4429  # … or since enough others look

Answer = Callable[[Request], Awaitable[Any]]


class Page:
    """The application of one server. `socket`: the daemon's."""

    def __init__(self, socket: str, guard: Guard) -> None:
        self._socket, self._guard = socket, guard
        self._feed = Feed(socket)
        self._planning, self._runs = Planning(socket), Runs(socket)
        self._views = 0
        self._asking: set[asyncio.Task[None]] = set()  # goes on when its window leaves

    def application(self) -> ASGIApp:
        routes = Starlette(
            routes=[
                Route("/", self._index),
                Route("/api/request", self._guarded(self._request), methods=["POST"]),
                Route("/api/maneuvers", self._guarded(self._maneuvers)),
                Route("/api/plan", self._guarded(self._plan), methods=["POST"]),
                Route("/api/runs", self._guarded(self._runs_newest)),
                Route("/api/report", self._guarded(self._make_report), methods=["POST"]),
                Route("/report/{ticket}", self._report),
                WebSocketRoute("/live", self._live),
                WebSocketRoute("/drive", self._drive),
                Mount("/static", StaticFiles(directory=STATIC)),
            ],
            lifespan=self._running,
        )
        return with_headers(routes)

    @asynccontextmanager
    async def _running(self, _application: Starlette) -> AsyncIterator[None]:
        feeding = asyncio.create_task(self._feed.run())
        try:
            yield
        finally:
            feeding.cancel()
            self._planning.close()
            self._runs.close()

    async def _index(self, request: Request) -> Response:
        try:
            self._guard.check_host(request.headers)
        except RequestError as error:
            return _refusal(error)
        return FileResponse(STATIC / "index.html")

    def _guarded(self, answer: Answer) -> Callable[[Request], Awaitable[Response]]:
        async def guarded(request: Request) -> Response:
            try:
                self._guard.check_request(request.headers)
                return Response(encode(await answer(request)), media_type="application/json")
            except LongreachError as error:
                return _refusal(error)

        return guarded

    async def _request(self, request: Request) -> dict[str, Any]:
        return await ask_daemon(self._socket, self._guard, request)

    async def _maneuvers(self, request: Request) -> dict[str, Any]:
        return {"maneuvers": await asyncio.to_thread(maneuver_forms), "shapers": list(KINDS)}

    async def _plan(self, request: Request) -> dict[str, Any]:
        return await self._planning.plan(await json_of(request, {"maneuver", "parameters", "shaper", "repeat", "approach"}))

    async def _runs_newest(self, request: Request) -> dict[str, Any]:
        return await self._runs.newest()

    async def _make_report(self, request: Request) -> dict[str, Any]:
        wanted = await json_of(request, {"log", "run"})
        return await self._runs.report(wanted.get("log"), wanted.get("run"))

    async def _report(self, request: Request) -> Response:
        """A page made from a log: shown, but nothing in it may run or reach this server."""
        try:
            self._guard.check_host(request.headers)
            page = self._runs.page_of(request.path_params["ticket"])
        except RequestError as error:
            return _refusal(error)
        return HTMLResponse(page, headers={"Content-Security-Policy": REPORT_POLICY})

    async def _live(self, window: WebSocket) -> None:
        """Live data for one window, from the moment it has sent the token."""
        if not await self._admitted(window, True):
            return
        if self._views >= MOST_VIEWS:
            await window.close(FULL_CODE)
            return
        self._views += 1
        try:
            with self._feed.watched() as pending:
                await self._send_until_left(window, pending)
        finally:
            self._views -= 1

    async def _drive(self, window: WebSocket) -> None:
        """Set points of one window, where the page may move the arm."""
        if await self._admitted(window, self._guard.control):
            await drive(window, self._socket)

    async def _admitted(self, window: WebSocket, allowed: bool) -> bool:
        """Whether a window at its own place has sent the token; it is closed if not."""
        try:
            self._guard.check_place(window.headers)
        except RequestError:
            await window.close()
            return False
        await window.accept()
        if allowed and await self._knows_token(window):
            return True
        await window.close(REFUSED_CODE)
        return False

    async def _send_until_left(self, window: WebSocket, pending: Pending) -> None:
        """A window that does not take what it is sent makes only this wait; see `Pending`."""
        sending = asyncio.create_task(_send(window, pending, self._guard.control))
        listening = asyncio.create_task(self._listen(window))
        done, waiting = await asyncio.wait((sending, listening), return_when=asyncio.FIRST_COMPLETED)
        for task in waiting:
            task.cancel()
        for task in done:
            with suppress(WebSocketDisconnect, RuntimeError):  # a window that closes while it is sent something
                task.result()

    async def _listen(self, window: WebSocket) -> None:
        """Until the window leaves. It can ask for an e-stop or a stop here too: a browser sends six other requests at a time at most, and
        these must not stand in that line, nor one behind the other."""
        while (message := await window.receive())["type"] != "websocket.disconnect":
            if message.get("text") in AT_ONCE and self._guard.control:
                asking = asyncio.create_task(self._ask_at_once(message["text"]))
                self._asking.add(asking)
                asking.add_done_callback(self._asking.discard)

    async def _ask_at_once(self, method: str) -> None:
        with suppress(LongreachError):  # the same request over HTTP says why
            await ask_once(self._socket, method, {}, AT_ONCE_LIMIT_S)

    async def _knows_token(self, window: WebSocket) -> bool:
        with suppress(RequestError, TimeoutError, WebSocketDisconnect, KeyError):
            async with asyncio.timeout(TOKEN_LIMIT_S):
                self._guard.check_token(await window.receive_text())
                return True
        return False


async def _send(window: WebSocket, pending: Pending, control: bool) -> None:
    await window.send_text(json.dumps({"control": control}))
    while True:
        await window.send_text(encode(await pending.take()).decode())


def _refusal(error: LongreachError) -> Response:
    """What the daemon refuses is an answer to the page, in the words of the socket; a browser would log any other status as a fault."""
    status = error.status if isinstance(error, RequestError) else 200
    return JSONResponse({"error": {"class": type(error).__name__, **error.refusal.as_dict()}}, status)
