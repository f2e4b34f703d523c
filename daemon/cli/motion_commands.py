"""`start` and `stop`: motion. `start` names what will move and counts down before it does."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

from rich.live import Live

from config.errors import DaemonError
from control.run_plan import TipMotion
from daemon.cli.check_table import console
from daemon.cli.connection import add_json_option, ask, connect, show
from daemon.cli.run_result import moves_of_run
from daemon.cli.shaper_option import SHAPERS, shaper_request
from daemon.cli.status_commands import status_view

_POLL_S = 0.2
_SETTLE_S = 10.0


def register(commands: Any) -> None:
    start = commands.add_parser("start", help="run a maneuver, after a countdown")
    start.add_argument("maneuver", help="name of a shipped maneuver, or a maneuver file")
    start.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change one parameter, e.g. --set y0='30 in'")
    start.add_argument("--shaper", default="none", choices=SHAPERS, help="command filter (default none)")
    start.add_argument(
        "--focal", default="mid", help="focal frequency of a fixed filter: initial, final, mid or a number in Hz (default mid)"
    )
    start.add_argument("--delay", metavar="T", help="spacing of three_term's impulses, e.g. '70 ms' (default: half a period, which is zvd)")
    start.add_argument("--both-joints", action="store_true", help="filter both joints, so that the line stays straight")
    start.add_argument("--repeat", type=int, default=1, metavar="N", help="run the program N times (default 1)")
    start.add_argument("--approach", action="store_true", help="first move slowly to where the maneuver starts")
    start.add_argument("--countdown", type=float, metavar="S", help="seconds of announcement (default: the rig's)")
    start.add_argument(
        "--settle",
        type=float,
        default=_SETTLE_S,
        metavar="S",
        help=f"wait at most S seconds until the tip is at rest (default {_SETTLE_S:g}; 0: start in spite of it)",
    )
    start.add_argument(
        "--wait", action="store_true", help="wait until the run has ended and say what vibration is left; exit 1 when it is invalid"
    )
    add_json_option(start)
    start.set_defaults(run_command=_start)

    stop = commands.add_parser("stop", help="controlled stop: decelerate along the path, then hold")
    add_json_option(stop)
    stop.set_defaults(run_command=_stop)


def maneuver_text(name_or_path: str) -> dict[str, str]:
    """A file is sent as text, because the daemon may not see the caller's directory; a bare name is looked up there."""
    path = Path(name_or_path)
    return {"text": path.read_text(encoding="utf-8"), "name": str(path)} if path.suffix in (".yaml", ".yml") else {"name": name_or_path}


def _start(arguments: argparse.Namespace) -> int:
    with connect(arguments) as client:
        status = client.call("status")
        if arguments.settle:
            _tell_waiting(status, arguments.settle)
        run = client.call("start", **_request(arguments, list(status["joints"])))
        _tell_tip(run)
        if not arguments.wait:
            show(
                arguments,
                run,
                f"run {run['run']} starts in {run['countdown_s']:.0f} s and takes {run['duration_s']:.1f} s; `longreach stop` stops it",
            )
            return 0
        return _wait(arguments, client, run)


def _request(arguments: argparse.Namespace, joints: list[str]) -> dict[str, Any]:
    request: dict[str, Any] = {
        "maneuver": maneuver_text(arguments.maneuver),
        "parameters": arguments.set,
        "shaper": shaper_request(arguments, joints),
        "repeat": arguments.repeat,
        "approach": arguments.approach,
    }
    if arguments.countdown is not None:
        request["countdown_s"] = arguments.countdown
    if arguments.settle:
        request["settle_s"] = arguments.settle
    return request


def _tell_waiting(status: dict[str, Any], limit_s: float) -> None:
    for check in status["at_rest"]:
        if not check["ok"] and status["mode"] == "holding":
            now = f"{check['name']}: {check['value']:.3g} {check['unit']} (limit {check['limit']})"
            print(f"waiting until the arm is at rest, at most {limit_s:g} s; {now}", file=sys.stderr, flush=True)


def _tell_tip(run: dict[str, Any]) -> None:
    """While the run is announced: how fast the tip will be, which a command filter may have made more than the maneuver says."""
    if run["tip"] is not None and run["tip"]["speed_mps"] > 0.0:
        print(TipMotion(**run["tip"]).text(), file=sys.stderr, flush=True)


def _wait(arguments: argparse.Namespace, client: Any, run: dict[str, Any]) -> int:
    if arguments.json:
        result = wait_for(client, run["run"])
        print(json.dumps({**result, "shaped_moves": [dataclasses.asdict(move) for move in moves_of_run(run, result)]}))
    else:
        with Live(console=console(), refresh_per_second=10) as live:
            result = wait_for(client, run["run"], lambda status: live.update(status_view(status)))
        print(f"run {run['run']}: {result['validity']}" + (f", because {result['reason']}" if result.get("reason") else ""))
        print("".join(f"  {move.text()}\n" for move in moves_of_run(run, result)), end="")
    return 0 if result["validity"] == "valid" else 1


def wait_for(client: Any, run: int, on_status: Any = None) -> dict[str, Any]:
    """Poll until the run has ended; `on_status` sees every status on the way."""
    while True:
        result: dict[str, Any] = client.call("wait", run=run, timeout_s=_POLL_S)
        if on_status:
            on_status(client.call("status"))
        if result["validity"] != "running":
            return result


def _stop(arguments: argparse.Namespace) -> int:
    try:
        show(arguments, ask(arguments, "stop"), "stopping along the path, then holding")
    except DaemonError:
        print("longreach: if the arm still moves, `longreach estop` makes the outputs safe at once", file=sys.stderr)
        raise
    return 0
