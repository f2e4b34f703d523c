"""`arm`, `disarm`, `reset`, `estop`: the verbs that change whether the arm may move. None of them moves it."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from config.errors import DaemonError
from daemon.cli.connection import add_json_option, ask, ask_to_stop, connect, show
from daemon.cli.estop_at_once import OUTPUTS_SAFE
from daemon.cli.shown.check_table import checks_lines
from daemon.cli.shown.shown_units import add_si_option, units_of_rig

_DONE = {
    "arm": "armed: the arm holds its position",
    "disarm": "disarmed: outputs are safe",
    "reset": "reset: the daemon is disarmed",
}


def arm_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--all", action="store_true", help="when it is refused, show every check and not only those that fail")
    add_si_option(parser)
    _verb(parser, "arm", _arm)


def disarm_options(parser: argparse.ArgumentParser) -> None:
    _verb(parser, "disarm", _tell)


def reset_options(parser: argparse.ArgumentParser) -> None:
    _verb(parser, "reset", _tell)


def estop_options(parser: argparse.ArgumentParser) -> None:
    _verb(parser, "estop", _estop)


def _verb(parser: argparse.ArgumentParser, verb: str, command: Callable[[argparse.Namespace], int]) -> None:
    add_json_option(parser)
    parser.set_defaults(run_command=command, verb=verb)


def _tell(arguments: argparse.Namespace) -> int:
    answer = ask(arguments, arguments.verb)
    still_fault = arguments.verb == "disarm" and answer.get("mode") == "fault"
    show(arguments, answer, "outputs are safe; the fault stays until `longreach reset`" if still_fault else _DONE[arguments.verb])
    return 0


def _estop(arguments: argparse.Namespace) -> int:
    show(arguments, ask_to_stop(arguments, "estop", "e-stop"), OUTPUTS_SAFE)
    return 0


def _arm(arguments: argparse.Namespace) -> int:
    """Arm; when checks refuse, show those and no others, unless all are asked for."""
    try:
        return _tell(arguments)
    except DaemonError as error:
        if arguments.json:
            raise
        with connect(arguments) as client:
            checks, units = client.call("checks")["checks"], units_of_rig(arguments, client.call)
        failed = [check for check in checks if not check["ok"]]
        print("".join(f"{line}\n" for line in checks_lines(checks if arguments.all else failed, units)), end="")
        raise _short(error, len(failed), len(checks)) from error


def _short(error: DaemonError, failed: int, of: int) -> DaemonError:
    """The refusal without the sentences of its checks, which stand above it; any other refusal as it is."""
    if "checks fail" not in error.refusal.what:
        return error
    advice = error.refusal.next_step if failed == 1 else "Put right what stands above; `longreach arm --all` shows every check."
    return DaemonError("arming refused", value=f"{failed} of {of} checks fail", next_step=advice.partition("). ")[2] or advice)
