"""`why`: why the arm will not move, now or at a moment of a recording. What passes is shown where it is asked for."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from config.errors import UsageError
from daemon.cli.connection import add_json_option, connect
from daemon.cli.options.numbers import finite
from daemon.cli.shown.check_table import checks_lines, standing
from daemon.cli.shown.shown_units import add_si_option, units_of_rig
from daemon.server.stated_values import Units

if TYPE_CHECKING:
    from recording.files.reader import Log


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("log", nargs="?", metavar="LOG.mcap", help="ask a recording instead of the daemon")
    parser.add_argument("--at", type=finite(), metavar="S", help="moment of the recording, column t_s (default: its end)")
    parser.add_argument("--all", action="store_true", help="show every check and not only those that fail or warn")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_why)


_NEXT = {
    "disarmed": "`longreach arm`",
    "holding": "it is armed, `longreach start MANEUVER`",
    "running": "it moves, `longreach stop` stops it",
}


def _why(arguments: argparse.Namespace) -> int:
    """Exit 0 when nothing stands in the way of arming, 1 when something does: a check that fails, or a fault that is latched."""
    if arguments.log is not None:
        return _why_then(arguments)
    if arguments.at is not None:
        raise UsageError(
            "--at is a moment of a recording", where="--at", next_step="`longreach why LOG.mcap --at S`; `longreach runs` lists logs."
        )
    with connect(arguments) as client:
        checks, units = client.call("checks")["checks"], units_of_rig(arguments, client.call)
        status, sentences = client.call("status"), client.sentences()
    failed, fault = [check for check in checks if not check["ok"]], status["fault"]
    ready = not failed and not fault
    if arguments.json:
        print(json.dumps({"ready": ready, "fault": fault, "checks": checks}))
        return 0 if ready else 1
    _print_checks(arguments, checks, units)
    if fault:
        print(f"a fault is latched: {fault['text'] if arguments.si else sentences.text(fault['text'])}")
    print(
        _outcome(failed, len(checks), status["mode"], bool(fault)) + ("" if arguments.all else "; `longreach why --all` shows every check")
    )
    return 0 if ready else 1


def _outcome(failed: list[dict[str, Any]], checks: int, mode: str, fault: bool) -> str:
    if failed:
        return f"{len(failed)} of {checks} checks {'stands' if len(failed) == 1 else 'stand'} in the way"
    if fault:
        return "all checks pass now: `longreach reset` clears the fault"
    return f"nothing stands in the way: {_NEXT.get(mode, '`longreach status`')}"


def _print_checks(arguments: argparse.Namespace, checks: list[dict[str, Any]], units: Units) -> None:
    shown = [check for check in checks if arguments.all or standing(check) is not True]
    print("".join(f"{line}\n" for line in checks_lines(shown, units)), end="")


def _why_then(arguments: argparse.Namespace) -> int:
    """The same of a moment of a recording, with the warnings and faults that led to it."""
    from daemon.checks.past_checks import checks_at
    from daemon.reports.stated_log import sentences_of, units_of_checks
    from recording.files.reader import read_log

    log = read_log(arguments.log)
    moment = checks_at(log, arguments.at)
    incident = _incident(log, moment.t_s)
    failed = [check for check in moment.checks if check["ok"] is False]
    if arguments.json:
        events = [{"t_s": event.t_s, "name": event.name, "text": event.text} for event in moment.events]
        found = {"t_s": moment.t_s, "cycle": moment.cycle, "mode": moment.mode.name.lower(), "checks": moment.checks, "events": events}
        found |= {"incident": incident}
        print(json.dumps(found))
        return 1 if failed else 0
    print(f"t {moment.t_s:.3f} s, cycle {moment.cycle}: {moment.mode.name.lower()}")
    known = [check for check in moment.checks if arguments.all or check["ok"] is not None]
    _print_checks(arguments, known, {} if arguments.si else units_of_checks(log, moment.checks))
    if not failed:
        print(f"no check that is in the log failed then{'' if arguments.all else '; --all shows every check'}")
    for event in moment.events:
        text = event.text if arguments.si else sentences_of(log).text(event.text)
        print(f"{event.t_s:10.3f} s  {event.name:<20} {text}")
    if incident:
        print(f"what led to the fault: {incident}")
    return 1 if failed else 0


def _incident(log: Log, t_s: float) -> str:
    """The page of the fault that the moment led to, or of the last one, or the command that makes it; empty where there was none."""
    from daemon.reports.incident import AFTER_S, faults_of, incident_page_of

    faults = faults_of(log)
    if not faults:
        return ""
    number = next((n for n, fault in enumerate(faults, 1) if t_s <= fault.t_s + AFTER_S), len(faults))
    page = incident_page_of(log.path, number)
    return str(page) if page.exists() else f"longreach log incident {log.path} --fault {number}"
