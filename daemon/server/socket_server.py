"""The Unix socket: lines in, lines out. Whatever a client sends is answered; nothing a client sends can end the daemon."""

from __future__ import annotations

import asyncio
import grp
import os
import shlex
import socket
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from config.socket_place import in_the_way
from daemon.server.client_connection import answer_for_client
from daemon.server.protocol import MAX_LINE_BYTES, error_line, parse_request, request_id_of, result_line

Methods = Mapping[str, Callable[[dict[str, Any]], Awaitable[dict[str, Any]]]]


@asynccontextmanager
async def serving(path: Path, group: str | None, methods: Methods) -> AsyncIterator[None]:
    """`serve` for a while. At its end the socket goes, unless somebody has put another one in its place."""
    server = await serve(path, group, methods)
    made = path.lstat()
    try:
        yield
    finally:
        server.close()
        with suppress(FileNotFoundError):
            if os.path.samestat(path.lstat(), made):
                path.unlink()


async def serve(path: Path, group: str | None, methods: Methods) -> asyncio.Server:
    """Listen at `path`, for the user and, if given, the group. DaemonError where somebody listens already, or another file stands."""
    _remove_leftover(path)
    umask = os.umask(0o177)  # nobody else may connect before the group is set
    try:
        server = await asyncio.start_unix_server(lambda reader, writer: _client(reader, writer, methods), path, limit=MAX_LINE_BYTES)
    except OSError as error:
        advice = "Give a shorter path in a directory this user may write with --socket."
        raise DaemonError("the socket cannot be made", value=error.strerror or str(error), where=str(path), next_step=advice) from error
    finally:
        os.umask(umask)
    if group is not None:
        _allow_group(path, group)
    return server


def _remove_leftover(path: Path) -> None:
    """A socket on which nobody listens was left by a daemon that was killed. Whose requests a living one gets must not change: an e-stop
    would go to the other rig."""
    there = in_the_way(path, socket.SOCK_STREAM)
    if there == "a file":
        raise DaemonError("the socket's place is taken by a file", where=str(path), next_step="Give another place with --socket.")
    if there:
        advice = f"Give another place with --socket; `longreach --socket {shlex.quote(str(path))} status` asks the daemon that is there."
        raise DaemonError("another daemon has this socket", where=str(path), next_step=advice)


def _allow_group(path: Path, group: str) -> None:
    try:
        os.chown(path, -1, grp.getgrnam(group).gr_gid)
    except (KeyError, OSError) as error:
        advice = "Create it (groupadd --system) and make the daemon's user a member, or leave --group away."
        raise DaemonError("the socket cannot be given to this group", value=group, where=str(path), next_step=advice) from error
    path.chmod(0o660)


async def _client(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, methods: Methods) -> None:
    answer_for_client(reader.at_eof)
    with suppress(ConnectionError):
        while line := await _line(reader, writer):
            writer.write(await answer(line, methods))
            await writer.drain()
    writer.close()


async def _line(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bytes:
    """The next line; empty at the end of the connection, and after a line that is too long."""
    try:
        return await reader.readuntil(b"\n")
    except asyncio.IncompleteReadError:
        return b""
    except asyncio.LimitOverrunError:
        too_long = DaemonError("a line is too long", limit=MAX_LINE_BYTES, unit="bytes", next_step="Send one JSON object a line.")
        writer.write(error_line(None, too_long))
        await writer.drain()
        return b""


async def answer(line: bytes, methods: Methods) -> bytes:
    """The answer to one line, whatever it holds."""
    try:
        request = parse_request(line)
        method = methods.get(request.method)
        if method is None:
            raise DaemonError("unknown method", value=request.method[:80], limit=", ".join(sorted(methods)))
        return result_line(request.id, await method(request.params))
    except Exception as error:  # a bug in one method must not take the daemon down; the client gets it as an error
        return error_line(request_id_of(line), error)
