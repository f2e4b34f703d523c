"""`arm`, `disarm`, `reset`, `estop`: the verbs that change whether the arm may move. None of them moves it."""

from __future__ import annotations

import argparse
from typing import Any

from config.errors import DaemonError
from daemon.cli.check_table import checks_lines, console
from daemon.cli.connection import add_json_option, ask, connect, show

_VERBS = {
    "arm": ("run the arming checks and hold the present position", "armed: the arm holds its position"),
    "disarm": ("safe outputs; motion needs a new `longreach arm`", "disarmed: outputs are safe"),
    "reset": ("clear a latched fault or e-stop; ends disarmed", "reset: the daemon is disarmed"),
    "estop": ("safe outputs at once, latched until `longreach reset`", "e-stop: outputs are safe; `longreach reset` clears it"),
}


def register(commands: Any) -> None:
    for verb, (summary, _) in _VERBS.items():
        parser = commands.add_parser(verb, help=summary, description=summary)
        add_json_option(parser)
        parser.set_defaults(run_command=_arm if verb == "arm" else _tell, verb=verb)


def _tell(arguments: argparse.Namespace) -> int:
    answer = ask(arguments, arguments.verb)
    still_fault = arguments.verb == "disarm" and answer.get("mode") == "fault"
    show(arguments, answer, "outputs are safe; the fault stays until `longreach reset`" if still_fault else _VERBS[arguments.verb][1])
    return 0


def _arm(arguments: argparse.Namespace) -> int:
    """Arm; when a check refuses, show all checks at once, not only the first that failed."""
    try:
        return _tell(arguments)
    except DaemonError:
        if not arguments.json:
            with connect(arguments) as client:
                console().print(*checks_lines(client.call("checks")["checks"]), sep="\n")
        raise
