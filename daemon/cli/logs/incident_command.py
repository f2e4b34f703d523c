"""`log incident`: the page of every fault of a log, and the time before it as a log of its own."""

from __future__ import annotations

import argparse

from daemon.cli.connection import add_json_option
from daemon.cli.logs.each_log import add_logs, say
from daemon.cli.options.numbers import COUNT


def options(parser: argparse.ArgumentParser) -> None:
    add_logs(parser, _incident)
    parser.add_argument("--fault", type=COUNT, metavar="N", help="only this fault of the log, counted from 1")
    add_json_option(parser)


def _incident(arguments: argparse.Namespace) -> int:
    from daemon.reports.incident import BEFORE_S
    from daemon.reports.incident_page import write_incidents

    written = write_incidents(arguments.log, arguments.fault)
    answer = {"log": arguments.log, "pages": [each.page for each in written], "logs": [each.log for each in written]}
    lines = [f"{each.page}\n{each.log}: the {BEFORE_S:.0f} s before the fault, a log of its own" for each in written]
    say(arguments, answer, "\n".join(lines))
    return 0
