"""A connection to the daemon's socket for asyncio. A request that is cancelled closes it, and the daemon then knows that nobody waits."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from os import PathLike
from typing import Any

from config.errors import DaemonError
from daemon.server.protocol import VERSION, encode, json_object, no_answer, result_of

LONGEST_ANSWER_BYTES = 64 << 20  # a history of events


class Connection:
    """Opened by the first `call`. One call at a time."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self.where = str(path)
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    async def call(self, method: str, params: Mapping[str, Any], timeout_s: float) -> dict[str, Any]:
        """The daemon's result. Raises its refusal, or DaemonError when it does not answer; the connection is closed then."""
        answered = False
        try:
            async with asyncio.timeout(timeout_s):
                answer = await self._exchange(encode({"v": VERSION, "id": 1, "method": method, "params": dict(params)}))
            answered = True
        except OSError as error:  # TimeoutError is one
            raise no_answer(self.where, error) from error
        except ValueError as error:
            raise DaemonError("the daemon's answer is too long", limit=LONGEST_ANSWER_BYTES, unit="bytes", where=self.where) from error
        finally:
            if not answered:
                self.close()
        return result_of(answer)

    async def _exchange(self, line: bytes) -> dict[str, Any]:
        if self._streams is None:
            self._streams = await asyncio.open_unix_connection(self.where, limit=LONGEST_ANSWER_BYTES)
        reader, writer = self._streams
        writer.write(line)
        await writer.drain()
        answer = await reader.readline()
        if not answer:
            raise ConnectionResetError("the daemon closed the connection")
        return json_object(answer)

    def close(self) -> None:
        if self._streams is not None:
            self._streams[1].close()
        self._streams = None


async def ask_once(path: str | PathLike[str], method: str, params: Mapping[str, Any], timeout_s: float) -> dict[str, Any]:
    """One request over a connection of its own, so that nothing stands before it in a line. Errors as `Connection.call`."""
    connection = Connection(path)
    try:
        return await connection.call(method, params, timeout_s)
    finally:
        connection.close()
