"""longreachd: makes the shared memory, starts control, recorder and io, serves the socket, tells systemd. Never part of the loop.

    longreachd RIG.yaml [--log-dir DIR] [--runtime-dir DIR] [--socket PATH] [--group NAME]

SIGTERM: controlled stop, safe outputs, logs closed, exit 0. A second SIGTERM: safe outputs at once. A dead control process ends
the daemon with status 1 after its log was closed; a dead recorder is a fault that a reset repairs. Nothing restarts silently.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import sys
from pathlib import Path

from config.errors import EXIT_REFUSED, LongreachError
from config.load import load_rig
from daemon import places
from daemon.crew import Crew
from daemon.desk import Desk
from daemon.notify import notify
from daemon.runtime_lock import RuntimeLock
from daemon.socket_server import serve


def main(argv: list[str] | None = None) -> int:
    """Exit status 0 after an orderly end, 1 after a refusal or the death of the control process, 2 wrong usage."""
    arguments = _parser().parse_args(argv)
    try:
        return asyncio.run(_run(arguments))
    except LongreachError as error:
        print(f"longreachd: {error}", file=sys.stderr, flush=True)
        notify(f"STATUS={error}")
        return EXIT_REFUSED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="longreachd", description="The longreach daemon: one rig, disarmed until somebody arms it.")
    parser.add_argument("rig", help="rig file, or the name of a shipped rig")
    parser.add_argument("--log-dir", help="where recordings go (default $LOGS_DIRECTORY or ./logs)")
    parser.add_argument(
        "--runtime-dir", help="lock, socket and output registers (default $RUNTIME_DIRECTORY, /run/longreach or the user's)"
    )
    parser.add_argument("--socket", help="where to listen (default longreach.sock in the runtime directory)")
    parser.add_argument("--group", help="members of this group may use the socket")
    return parser


async def _run(arguments: argparse.Namespace) -> int:
    loaded = load_rig(arguments.rig)
    runtime, log_dir = places.runtime_directory(arguments.runtime_dir), places.log_directory(arguments.log_dir)
    socket_path = Path(arguments.socket) if arguments.socket else runtime / "longreach.sock"
    lock = RuntimeLock(runtime)
    log_dir.mkdir(parents=True, exist_ok=True)
    crew = Crew(loaded, log_dir.absolute(), runtime.absolute(), lock)
    desk = Desk(loaded.rig, crew.facts, crew.journal, crew.view, crew.values, crew.post, crew.repair_recorder, crew.shut_down)
    server = None
    try:
        crew.start(desk)
        for number in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(number, crew.shut_down)
        await crew.until_ready()
        server = await serve(socket_path, arguments.group, desk.methods)
        print(f"longreachd: {loaded.rig.name} is disarmed; socket {socket_path}, logs {log_dir}, process {os.getpid()}", flush=True)
        notify("READY=1", "STATUS=disarmed")
        return await crew.watch()
    finally:
        if server is not None:
            server.close()
            socket_path.unlink(missing_ok=True)
        crew.kill()
        lock.close()


if __name__ == "__main__":
    sys.exit(main())
