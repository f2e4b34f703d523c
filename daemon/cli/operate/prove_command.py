"""`prove`: the valves and output modules show that they go to their safe state by themselves. They move; the pressure must be off."""

from __future__ import annotations

import argparse
import json
from typing import Any

from config.errors import EXIT_REFUSED
from daemon.cli.connection import add_json_option, connect
from daemon.cli.options.countdown import add_countdown_option

_DESCRIPTION = """\
Every device with outputs opens a little; then our heartbeat stops, later our set points, and each time the device must go safe by itself.
Once after every start of the daemon, with the hydraulic pressure OFF. Arming asks for it. Exit 1 when something is not proven.
"""


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = _DESCRIPTION
    add_countdown_option(parser)
    parser.add_argument("--pressure-is-off", action="store_true", help="your word for it, where no sensor measures the supply pressure")
    add_json_option(parser)
    parser.set_defaults(run_command=_prove)


def _prove(arguments: argparse.Namespace) -> int:
    request: dict[str, Any] = {"pressure_is_off": True} if arguments.pressure_is_off else {}
    if arguments.countdown is not None:
        request["countdown_s"] = arguments.countdown
    with connect(arguments) as client:
        if not arguments.json:
            _announce(client.call("status")["safe_state"])
        answer = client.call("prove", **request)
    if arguments.json:
        print(json.dumps(answer))
    else:
        _show(answer)
    return 0 if answer["good"] else EXIT_REFUSED


def _announce(devices: dict[str, Any]) -> None:
    if devices:
        print(f"The outputs of {', '.join(devices)} MOVE after the countdown; the hydraulic pressure must be off.", flush=True)


def _show(answer: dict[str, Any]) -> None:
    for result in answer["results"]:
        print(f"{'ok ' if result['ok'] else 'NO '} {result['text']}")
    for failure in answer["failures"]:
        print(f"NO  {failure}")
    print(
        "the safe state is proven: `longreach arm`" if answer["good"] else f"the safe state is NOT proven; the daemon is {answer['mode']}"
    )
