"""A daemon's socket in a thread, over a loop in lockstep: cheap, and it never falls behind."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from daemon.lockstep import LockstepRig
from daemon.server.socket_server import serve
from tests.support.daemon.lockstep_requests import LockstepRequests
from tests.support.daemon.rigs import RIG


@contextmanager
def lockstep_daemon(directory: Path) -> Iterator[Path]:
    """The path of its socket."""
    path = directory / "lockstep.sock"
    loop = asyncio.new_event_loop()
    with LockstepRig(RIG, directory) as rig:
        requests = LockstepRequests(rig, RIG.text)
        rig.cycles(5)

        async def serve_until_stopped() -> None:
            server = await serve(path, None, requests.handlers.methods)
            listening.set()
            await ended.wait()
            server.close()

        ended, listening = asyncio.Event(), threading.Event()
        serving = threading.Thread(target=loop.run_until_complete, args=(serve_until_stopped(),))
        serving.start()
        assert listening.wait(20.0)
        try:
            yield path
        finally:
            loop.call_soon_threadsafe(ended.set)
            serving.join(20.0)
            loop.close()
