"""longreachd: makes the shared memory, starts control, recorder and io, serves the socket, notifies systemd. Never part of the loop.

    longreachd RIG.yaml [--log-dir DIR] [--runtime-dir DIR] [--socket PATH] [--group NAME]

SIGTERM, Ctrl-C and the end of its terminal: controlled stop, safe outputs, logs closed, exit 0. A second one: safe outputs at once. A
dead control process ends the daemon with status 1 after its log was closed; a dead recorder is a fault that a reset repairs. Nothing
restarts silently.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import shlex
import signal
import sys
from pathlib import Path
from typing import NoReturn

from config.checking.check import refuse_unusable
from config.errors import EXIT_INTERRUPTED, EXIT_REFUSED, EXIT_USAGE, LongreachError
from config.loading.load import LoadedRig, load_rig
from config.whole_file import refused_by_system
from daemon.processes import paths
from daemon.processes.child_supervision import ChildSupervision
from daemon.processes.runtime_lock import RuntimeLock
from daemon.processes.sd_notify import notify
from daemon.server.request_handlers import RequestHandlers
from daemon.server.socket_server import serving
from daemon.server.until_ctrl_c import until_ctrl_c


def main(argv: list[str] | None = None) -> int:
    """Exit status 0 after an orderly end, 1 after a refusal or the death of the control process, 2 wrong usage, 130 where Ctrl-C came
    before anything was started."""
    arguments = _parser().parse_args(argv)
    try:
        return until_ctrl_c(_run(arguments))
    except (LongreachError, OSError) as error:
        refusal = error if isinstance(error, LongreachError) else refused_by_system(error)
        print(f"longreachd: {refusal}\nnext: {_next_command(refusal, arguments.rig)}", file=sys.stderr, flush=True)
        notify(f"STATUS={refusal}")
        return EXIT_REFUSED
    except KeyboardInterrupt:
        print("longreachd: ended by Ctrl-C before anything was started", file=sys.stderr, flush=True)
        return EXIT_INTERRUPTED


def _next_command(refusal: LongreachError, rig: str) -> str:
    """What the refusal names; the rig that was meant; else the command that says more about the rig file."""
    named = refusal.refusal.named_command()
    meant = re.search(r"nearest is '([^']*)'", refusal.refusal.what) if not rig.endswith((".yaml", ".yml")) else None
    better = refusal.refusal.mend.get(rig) or (meant[1] if meant else None)
    return named or (f"longreachd {shlex.quote(better)}" if better else f"longreach check {shlex.quote(rig)}")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(EXIT_USAGE, f"{self.prog}: {message}\nnext: {self.prog} --help\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="longreachd", description="The longreach daemon: one rig, disarmed until somebody arms it.")
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
    refuse_unusable(loaded)
    runtime, log_dir = paths.runtime_directory(arguments.runtime_dir), paths.log_directory(arguments.log_dir)
    lock = RuntimeLock(runtime)
    log_dir.mkdir(parents=True, exist_ok=True)
    children = ChildSupervision(loaded, log_dir.absolute(), runtime.absolute(), lock)
    try:
        return await _serve(loaded, children, arguments, runtime, log_dir)
    finally:
        await children.end()
        lock.close()


async def _serve(rig: LoadedRig, children: ChildSupervision, arguments: argparse.Namespace, runtime: Path, log_dir: Path) -> int:
    """From the start of the child processes to their end, with the socket open while the loop runs."""
    handlers = RequestHandlers(rig.rig, children, rig.text)
    hang_up = [] if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN else [signal.SIGHUP]  # nohup: it outlives its terminal
    for number in (signal.SIGTERM, signal.SIGINT, *hang_up):
        asyncio.get_running_loop().add_signal_handler(number, children.shut_down)
    children.start(handlers)
    await children.until_ready()
    if children.leaving:
        print(f"longreachd: {rig.rig.name} was told to end while it started; its outputs stayed safe", flush=True)
        return await children.watch()
    socket_path = Path(arguments.socket) if arguments.socket else runtime / "longreach.sock"
    async with serving(socket_path, arguments.group, handlers.methods):
        print(f"longreachd: {rig.rig.name} is disarmed; socket {socket_path}, logs {log_dir}, process {os.getpid()}", flush=True)
        notify("READY=1", "STATUS=disarmed")
        return await children.watch()


if __name__ == "__main__":
    sys.exit(main())
