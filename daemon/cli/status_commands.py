"""`status`, `why`, `maneuvers`, `events`: look without touching."""

from __future__ import annotations

import argparse
import json
import math
import time
from typing import Any

from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from daemon.cli.check_table import checks_lines, console
from daemon.cli.connection import add_json_option, ask, connect
from daemon.past_checks import checks_at
from recording.reader import read_log

_MODE_STYLE = {
    "disarmed": "white",
    "arming": "yellow",
    "holding": "cyan",
    "running": "green",
    "stopping": "yellow",
    "fault": "red bold",
    "proving": "yellow",
}
_SHOWN_IN = {"rad": (180.0 / math.pi, "deg"), "m": (1e3, "mm")}


def register(commands: Any) -> None:
    status = commands.add_parser("status", help="what the daemon and the arm are doing now")
    status.add_argument("--watch", action="store_true", help="refresh until interrupted")
    status.add_argument("--interval", type=float, default=0.2, metavar="S", help="seconds between refreshes (default 0.2)")
    add_json_option(status)
    status.set_defaults(run_command=_status)

    why = commands.add_parser("why", help="why the arm will not move: every check with value, limit, unit, source and age")
    why.add_argument("log", nargs="?", metavar="LOG.mcap", help="ask a recording instead of the daemon")
    why.add_argument("--at", type=float, metavar="S", help="moment of the recording, column t_s (default: its end)")
    add_json_option(why)
    why.set_defaults(run_command=_why)

    maneuvers = commands.add_parser("maneuvers", help="the maneuvers that can be started")
    add_json_option(maneuvers)
    maneuvers.set_defaults(run_command=_maneuvers)

    events = commands.add_parser("events", help="mode changes, commands, interlocks and faults since the daemon started")
    events.add_argument("--since", type=int, default=0, metavar="N", help="only events after number N")
    add_json_option(events)
    events.set_defaults(run_command=_events)


def _status(arguments: argparse.Namespace) -> int:
    with connect(arguments) as client:
        if not arguments.watch:
            _print_status(arguments, client.call("status"))
            return 0
        if arguments.json:
            return _watch_json(arguments, client)
        with Live(console=console(), refresh_per_second=10) as live:
            while True:
                live.update(status_view(client.call("status")))
                time.sleep(arguments.interval)


def _watch_json(arguments: argparse.Namespace, client: Any) -> int:
    while True:
        print(json.dumps(client.call("status")), flush=True)
        time.sleep(arguments.interval)


def _print_status(arguments: argparse.Namespace, status: dict[str, Any]) -> None:
    if arguments.json:
        print(json.dumps(status))
    else:
        console().print(status_view(status))


def status_view(status: dict[str, Any]) -> Group:
    """One screen: mode, run, joints, loop health, log, fault."""
    mode = str(status["mode"])
    parts: list[Any] = [
        Text.assemble(f"{status['rig']}  ", (mode, _MODE_STYLE.get(mode, "white")), f"  cycle {status['cycle']}  t {status['t_s']:.1f} s")
    ]
    if status.get("run"):
        parts.append(Text(run_line(status["run"])))
    parts.append(_joint_table(status["joints"]))
    loop = status["loop"]
    parts.append(
        Text(
            f"loop {loop['rate_Hz']:.0f} Hz  overruns {loop['overruns']}  drops {loop['drops']}  "
            f"late p99 {loop['late_us_p99']:.0f} us   log {status['log']['path']}"
        )
    )
    parts.extend(Text(link["text"]) for link in status["links"].values())
    if status.get("fault"):
        parts.append(Text(f"fault: {status['fault']['text']}", style="red bold"))
    return Group(*parts)


def run_line(run: dict[str, Any]) -> str:
    """One line on a run: what, which filter, where in the program, and how it stands."""
    line = f"run {run['run']}: {run['maneuver']}, filter {run['shaper']}"
    if run.get("countdown_s", 0) > 0:
        return f"{line}  MOTION STARTS IN {run['countdown_s']:.0f} s"
    line += f"  {run['elapsed_s']:.1f} of {run['duration_s']:.1f} s" + (f", {run['segment_name']}" if run["segment_name"] else "")
    if run["validity"] != "running":
        line += f"  {run['validity']}" + (f", because {run['reason']}" if run.get("reason") else "")
    return line


def _joint_table(joints: dict[str, dict[str, Any]]) -> Table:
    table = Table(header_style="bold")
    for heading in ("joint", "position", "reference", "error", "velocity", "command"):
        table.add_column(heading, justify="left" if heading == "joint" else "right")
    for name, joint in joints.items():
        scale, unit = _SHOWN_IN.get(joint["unit"], (1.0, joint["unit"]))
        position, reference = _scaled(joint["position"], scale), _scaled(joint["reference"], scale)
        table.add_row(
            name,
            f"{position:.2f} {unit}",
            f"{reference:.2f} {unit}",
            f"{reference - position:+.3f} {unit}",
            f"{_scaled(joint['velocity'], scale):+.2f} {unit}/s",
            f"{_scaled(joint['command_V'], 1.0):+.3f} V",
        )
    return table


def _scaled(value: float | None, scale: float) -> float:
    return math.nan if value is None else value * scale


def _why(arguments: argparse.Namespace) -> int:
    """Exit 0 when nothing stands in the way of arming, 1 when something does."""
    if arguments.log is not None:
        return _why_then(arguments)
    checks = ask(arguments, "checks")["checks"]
    failed = [check for check in checks if not check["ok"]]
    if arguments.json:
        print(json.dumps({"ready": not failed, "checks": checks}))
        return 1 if failed else 0
    console().print(*checks_lines(checks), sep="\n")
    print(f"{len(failed)} of {len(checks)} checks stand in the way" if failed else "nothing stands in the way: `longreach arm`")
    return 1 if failed else 0


def _why_then(arguments: argparse.Namespace) -> int:
    """The same of a moment of a recording, with the warnings and faults that led to it."""
    moment = checks_at(read_log(arguments.log), arguments.at)
    failed = [check for check in moment.checks if check["ok"] is False]
    if arguments.json:
        events = [{"t_s": event.t_s, "name": event.name, "text": event.text} for event in moment.events]
        found = {"t_s": moment.t_s, "cycle": moment.cycle, "mode": moment.mode.name.lower(), "checks": moment.checks, "events": events}
        print(json.dumps(found))
        return 1 if failed else 0
    print(f"t {moment.t_s:.3f} s, cycle {moment.cycle}: {moment.mode.name.lower()}")
    console().print(*checks_lines(moment.checks), sep="\n")
    for event in moment.events:
        print(f"{event.t_s:10.3f} s  {event.name:<20} {event.text}")
    return 1 if failed else 0


def _maneuvers(arguments: argparse.Namespace) -> int:
    maneuvers = ask(arguments, "maneuvers")["maneuvers"]
    if arguments.json:
        print(json.dumps(maneuvers))
        return 0
    table = Table(header_style="bold")
    for heading in ("name", "kind", "description"):
        table.add_column(heading)
    for maneuver in maneuvers:
        table.add_row(maneuver["name"], maneuver["kind"], maneuver["description"])
    console().print(table)
    return 0


def _events(arguments: argparse.Namespace) -> int:
    answer = ask(arguments, "events", since=arguments.since)
    if arguments.json:
        print(json.dumps(answer))
        return 0
    for event in answer["events"]:
        print(f"{event['t_s']:10.3f} s  {event['name']:<20} {event['text']}")
    return 0
