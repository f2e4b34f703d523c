"""`play`: a log into any of the live views, at any speed."""

from __future__ import annotations

import argparse

from daemon.cli.options.numbers import PORT, finite

_VIEWS = ("ui", "top", "live")


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("log", metavar="LOG.mcap", help="a log that longreach wrote or imported with a rig file")
    parser.add_argument("view", nargs="?", choices=_VIEWS, help="where to show it; left out: serve it at --at until interrupted")
    parser.add_argument("--speed", type=finite(), default=1.0, metavar="X", help="seconds of the log a second (default 1)")
    parser.add_argument("--from", type=finite(), default=0.0, dest="from_s", metavar="S", help="begin so long after the log's first row")
    parser.add_argument("--at", metavar="SOCKET", help="the socket to answer at (default: one of its own)")
    parser.add_argument("--port", type=PORT, metavar="N", help="of ui and live")
    parser.set_defaults(run_command=_play)


def _play(arguments: argparse.Namespace) -> int:
    import asyncio
    import tempfile
    from contextlib import suppress
    from pathlib import Path

    from daemon.live.playback.log_player import LogPlayer
    from daemon.live.playback.played import played, serve_played
    from daemon.server.until_ctrl_c import until_ctrl_c
    from recording.files.reader import read_log

    player = LogPlayer(read_log(arguments.log), arguments.speed, arguments.from_s)
    with tempfile.TemporaryDirectory(prefix="longreach-play-") as directory:
        socket = Path(arguments.at or f"{directory}/play.sock")
        if arguments.view is None:
            views = f"longreach --socket {socket} top (or ui, live, status, why)"

            def ready() -> None:
                print(f"{arguments.log} at {arguments.speed:g} × real time: {views}", flush=True)

            with suppress(KeyboardInterrupt):
                until_ctrl_c(serve_played(player, socket, asyncio.Event(), ready))
            return 0
        with played(player, socket):
            return _show(arguments, str(socket))


def _show(arguments: argparse.Namespace, socket: str) -> int:
    """The view as its own command would show a daemon."""
    from daemon.cli.command_line import build_parser

    port = ["--port", str(arguments.port)] if arguments.port is not None and arguments.view != "top" else []
    view = build_parser().parse_args(["--socket", socket, arguments.view, *port])
    status: int = view.run_command(view)
    return status
