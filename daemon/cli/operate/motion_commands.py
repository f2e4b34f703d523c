"""`start` and `stop`: motion. `start` names what will move and counts down before it does."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from config.stated_sentences import StatedSentences
from daemon.cli.connection import add_json_option, ask_to_stop, connect, show
from daemon.cli.operate.status_commands import status_view
from daemon.cli.options.countdown import add_countdown_option
from daemon.cli.options.numbers import COUNT, finite
from daemon.cli.options.shaper import add_shaper_options, shaper_request
from daemon.cli.shown.shown_units import add_si_option, units_of_rig
from daemon.cli.shown.terminal import LiveScreen
from daemon.server.protocol import LONGEST_SETTLE_S

_POLL_S = 0.2
_SETTLE_S = 10.0
_STOPPED = {
    "stopping": "stopping along the path, then holding",
    "holding": "nothing moves: the arm holds its position",
    "disarmed": "nothing moves: the daemon is disarmed, outputs are safe",
    "fault": "nothing moves: the daemon is in a fault, outputs are safe; `longreach why` says why",
}


def start_options(start: argparse.ArgumentParser) -> None:
    start.add_argument("maneuver", help="name of a shipped maneuver, or a maneuver file")
    start.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change one parameter, e.g. --set y0='30 in'")
    add_shaper_options(start)
    start.add_argument("--repeat", type=COUNT, default=1, metavar="N", help="run the program N times (default 1)")
    start.add_argument("--approach", action="store_true", help="first move slowly to where the maneuver starts")
    add_countdown_option(start)
    start.add_argument(
        "--settle",
        type=finite(0, LONGEST_SETTLE_S, "s"),
        default=_SETTLE_S,
        metavar="S",
        help=f"wait at most S seconds until the tip is at rest (default {_SETTLE_S:g}; 0: start in spite of it)",
    )
    start.add_argument(
        "--wait",
        action="store_true",
        help="wait for the run's end, say what vibration is left, make the run's page; exit 1 when it is invalid",
    )
    start.add_argument("--no-report", action="store_true", help="with --wait: no page of the run (`longreach log report` makes it later)")
    add_si_option(start)
    add_json_option(start)
    start.set_defaults(run_command=_start)


def stop_options(stop: argparse.ArgumentParser) -> None:
    add_json_option(stop)
    stop.set_defaults(run_command=_stop)


def maneuver_text(name_or_path: str) -> dict[str, str]:
    """A file is sent as text, because the daemon may not see the caller's directory; a bare name is looked up there."""
    from config.loading.load import read_text
    from config.loading.shipped import find

    path = Path(name_or_path)
    if Path(f"{name_or_path}.yaml").is_file():
        find("maneuvers", name_or_path)  # refuses with that file, unless the name is a shipped one
    return {"text": read_text(path), "name": str(path)} if path.suffix in (".yaml", ".yml") else {"name": name_or_path}


def _start(arguments: argparse.Namespace) -> int:
    with connect(arguments) as client:
        status = client.call("status")
        if arguments.settle:
            _tell_waiting(status, arguments.settle)
        run = client.call("start", **_request(arguments, list(status["joints"])))
        _tell_tip(run, client.sentences())
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


def _tell_tip(run: dict[str, Any], sentences: StatedSentences) -> None:
    """While the run is announced: how fast the tip will be, which a command filter may have made more than the maneuver says."""
    from servo_control.planning.run_plan import TipMotion

    if run["tip"] is not None and run["tip"]["speed_mps"] > 0.0:
        print(sentences.text(TipMotion(**run["tip"]).text()), file=sys.stderr, flush=True)


def _wait(arguments: argparse.Namespace, client: Any, run: dict[str, Any]) -> int:
    from daemon.cli.run_result import moves_of_run, report_of_run

    if arguments.json:
        result = wait_for(client, run["run"])
        moves = [dataclasses.asdict(move) for move in moves_of_run(run, result)]
        print(json.dumps({**result, "shaped_moves": moves, "report": [] if arguments.no_report else report_of_run(run, result)}))
    else:
        units = units_of_rig(arguments, client.call)
        with LiveScreen() as screen:
            result = wait_for(client, run["run"], lambda status: screen.update(status_view(status, units)))
        because = f", because {client.sentences().text(result['reason'])}" if result.get("reason") else ""
        print(f"run {run['run']}: {result['validity']}{because}")
        print("".join(f"  {move.text()}\n" for move in moves_of_run(run, result)), end="", flush=True)
        for page in [] if arguments.no_report else report_of_run(run, result):
            print(f"report: {page}")
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
        answer = ask_to_stop(arguments, "stop", "stop")
    except DaemonError as error:
        if error.__cause__ is None:
            print("longreach: if the arm still moves, `longreach estop` makes the outputs safe at once", file=sys.stderr)
        raise
    show(arguments, answer, _STOPPED.get(str(answer.get("mode")), _STOPPED["stopping"]))
    return 0
