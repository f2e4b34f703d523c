"""What the page may ask of the daemon: the requests of the socket, word for word, and without --control only those that look."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable
from typing import Any

from starlette.requests import Request

from config.errors import DaemonError
from daemon.live.page.guard import Guard, RequestError
from daemon.live.source.connection import ask_once

LOOKS = ("status", "checks", "units", "events", "maneuvers", "wait")
ACTS = ("arm", "disarm", "reset", "start", "stop", "estop", "prove")
MOST_BYTES = 64 << 10
LONGEST_S = 120.0  # a proof, or waiting for rest before a start


async def json_of(request: Request, keys: set[str]) -> dict[str, Any]:
    """The request's JSON object with no other keys than these. RequestError for any other content."""
    if request.headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
        raise RequestError(415, "the content must be application/json")
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MOST_BYTES:
            raise RequestError(413, f"the content is longer than {MOST_BYTES} bytes")
    try:
        content = json.loads(body)
    except (ValueError, RecursionError) as error:
        raise RequestError(400, "the content is no JSON") from error
    if not isinstance(content, dict) or not set(content) <= keys:
        raise RequestError(400, f"the content must be an object of {', '.join(sorted(keys))}")
    return content


async def ask_daemon(socket: str, guard: Guard, request: Request) -> dict[str, Any]:
    """The daemon's result. RequestError for what the page may not ask; raises the daemon's refusals."""
    content = await json_of(request, {"method", "params"})
    method, params = content.get("method"), content.get("params", {})
    if not isinstance(method, str) or not isinstance(params, dict):
        raise RequestError(400, "a request needs a method (text) and params (object)")
    if method in ACTS and not guard.control:
        advice = f"Use `longreach {method}`, or start `longreach ui --control`."
        raise RequestError(403, f"this page only looks: {method} is refused", advice)
    if method not in (*LOOKS, *ACTS):
        raise RequestError(400, "no request of the page", f"Known are {', '.join((*LOOKS, *ACTS))}.")
    return await while_connected(request, ask_once(socket, method, params, LONGEST_S))


async def while_connected(request: Request, work: Awaitable[dict[str, Any]]) -> dict[str, Any]:
    """The result of `work`, which is cancelled when the browser leaves: motion must not begin once nobody is there to stop it."""
    working = asyncio.ensure_future(work)
    leaving = asyncio.ensure_future(_left(request))
    try:
        await asyncio.wait((working, leaving), return_when=asyncio.FIRST_COMPLETED)
        if working.done():
            return working.result()
        raise DaemonError("the browser left before the answer")
    finally:
        working.cancel()
        leaving.cancel()


async def _left(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
