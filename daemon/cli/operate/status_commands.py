"""`status`, `maneuvers`, `events`: look without touching."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from typing import Any

from config.readable import number
from daemon.cli.connection import add_json_option, connect
from daemon.cli.options.numbers import finite, whole
from daemon.cli.shown.shown_units import add_si_option, units_of_rig
from daemon.cli.shown.terminal import LiveScreen, coloured, text_table
from daemon.server.loop_silence import ADVICE, sentence
from daemon.server.stated_values import Units

_MODE_COLOURS = {"arming": "yellow", "holding": "cyan", "running": "green", "stopping": "yellow", "fault": "red", "proving": "yellow"}


def status_options(parser: argparse.ArgumentParser) -> None:
    add_si_option(parser)
    parser.add_argument("--watch", action="store_true", help="refresh until interrupted")
    parser.add_argument(
        "--interval", type=finite(0.01, 3600, "s"), default=0.2, metavar="S", help="seconds between refreshes (default 0.2)"
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_status)


def maneuvers_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--all", action="store_true", help="those that this rig cannot run as well, each with the reason")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_maneuvers)


def events_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--since", type=whole(0), default=0, metavar="N", help="only events after number N")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_events)


def _status(arguments: argparse.Namespace) -> int:
    with connect(arguments) as client:
        if arguments.json:
            return _watch_json(arguments, client) if arguments.watch else _print_json(client.call("status"))
        units, sentences = units_of_rig(arguments, client.call), client.sentences()

        def lines() -> list[str]:
            status = client.call("status")
            return [*(sentences.text(line) for line in status_view(status, units)), *readings_view(status, units)]

        if not arguments.watch:
            print("\n".join(lines()))
            return 0
        while not sys.stdout.isatty():
            print("\n".join(lines()), end="\n\n", flush=True)
            time.sleep(arguments.interval)
        with LiveScreen() as screen:
            while True:
                screen.update(lines())
                time.sleep(arguments.interval)


def _watch_json(arguments: argparse.Namespace, client: Any) -> int:
    while True:
        print(json.dumps(client.call("status")), flush=True)
        time.sleep(arguments.interval)


def _print_json(answer: Any) -> int:
    print(json.dumps(answer))
    return 0


def status_view(status: dict[str, Any], units: Units | None = None) -> list[str]:
    """The lines of one screen: mode, run, joints, loop health, log, links, fault."""
    mode, loop = str(status["mode"]), status["loop"]
    return [
        f"{status['rig']}  {coloured(mode, _MODE_COLOURS.get(mode, ''))}  cycle {status['cycle']}  t {status['t_s']:.1f} s",
        *([coloured(f"{sentence(loop['silent_s'])}. {ADVICE}", "red")] if loop.get("silent_s") else []),
        *([run_line(status["run"])] if status.get("run") else []),
        *_joint_table(status["joints"], units or {}),
        f"loop {loop['rate_Hz']:.0f} Hz  overruns {loop['overruns']}  drops {loop['drops']}  late p99 {loop['late_us_p99']:.0f} us"
        f"   log {status['log']['path']}",
        *(link["text"] for link in status["links"].values()),
        *([coloured(f"fault: {status['fault']['text']}", "red")] if status.get("fault") else []),
    ]


def readings_view(status: dict[str, Any], units: Units) -> list[str]:
    """What is measured besides the joints' positions, a line for every place; none from a daemon of before this."""
    lines: dict[str, list[str]] = {}
    for name, reading in status.get("readings", {}).items():
        place, _, signal = name.rpartition(".")
        if signal == "position" and place in status["joints"]:
            continue
        unit, scale, offset = units.get(name, (reading["unit"], 1.0, 0.0))
        value = "–" if reading["value"] is None else f"{number(scale * reading['value'] + offset)} {unit}".strip()
        lines.setdefault(place or "rig", []).append(f"{signal.replace('_', ' ')} {value}")
    return [f"{place}: {', '.join(said)}" for place, said in lines.items()]


def run_line(run: dict[str, Any]) -> str:
    """One line on a run: what, which filter, where in the program, and how it stands."""
    line = f"run {run['run']}: {run['maneuver']}, filter {run['shaper']}"
    if run.get("countdown_s", 0) > 0:
        return f"{line}  MOTION STARTS IN {run['countdown_s']:.0f} s"
    of = "" if run["duration_s"] is None else f" of {run['duration_s']:.1f}"  # driven by hand: nobody knows
    line += f"  {run['elapsed_s']:.1f}{of} s" + (f", {run['segment_name']}" if run["segment_name"] else "")
    if run["validity"] != "running":
        line += f"  {run['validity']}" + (f", because {run['reason']}" if run.get("reason") else "")
    return line


def _joint_table(joints: dict[str, dict[str, Any]], units: Units) -> list[str]:
    rows = []
    for name, joint in joints.items():
        unit, scale, _ = units.get(name, (joint["unit"], 1.0, 0.0))
        position, reference, velocity = (_scaled(joint[word], scale) for word in ("position", "reference", "velocity"))
        volts = _scaled(joint["command_V"], 1.0)
        rows.append(
            [
                name,
                _known(position, number(position), unit),
                _known(reference, number(reference), unit),
                _known(reference - position, f"{reference - position:+.3g}", unit),
                _known(velocity, f"{velocity:+.3g}", f"{unit}/s"),
                _known(volts, f"{volts:+.3f}", "V"),
            ]
        )
    return text_table(["joint", "position", "reference", "error", "velocity", "command"], rows)


def _known(value: float, text: str, unit: str) -> str:
    return f"{text} {unit}" if math.isfinite(value) else "–"


def _scaled(value: float | None, scale: float) -> float:
    return math.nan if value is None else value * scale


def _maneuvers(arguments: argparse.Namespace) -> int:
    with connect(arguments) as client:
        maneuvers, sentences = client.call("maneuvers")["maneuvers"], client.sentences()
    if arguments.json:
        return _print_json(maneuvers)
    others = [maneuver for maneuver in maneuvers if maneuver.get("reason")]  # a daemon of before this says none
    shown = [maneuver for maneuver in maneuvers if maneuver not in others]
    rows = [[maneuver[key] for key in ("name", "kind", "description")] for maneuver in shown]
    print("\n".join(text_table(["name", "kind", "description"], rows, left=(0, 1, 2))))
    if arguments.all:
        for maneuver in others:
            print(f"not on this rig: {maneuver['name']}: {sentences.text(maneuver['reason'])}")
    elif others:
        print(f"{len(others)} more cannot run on this rig: `longreach maneuvers --all` says why")
    return 0


def _events(arguments: argparse.Namespace) -> int:
    with connect(arguments) as client:
        answer, sentences = client.call("events", since=arguments.since), client.sentences()
    if arguments.json:
        return _print_json(answer)
    for event in answer["events"]:
        print(f"{event['t_s']:10.3f} s  {event['name']:<20} {sentences.text(event['text'])}")
    return 0
