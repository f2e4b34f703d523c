"""`log report`: the page of every run of a log; or every page that a folder of logs lacks, once or as logs are closed."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path

from config.errors import UsageError
from daemon.cli.connection import add_json_option
from daemon.cli.logs.each_log import add_logs, folder_of, say
from daemon.cli.options.numbers import COUNT

LOWEST = 19  # priority


def options(parser: argparse.ArgumentParser) -> None:
    add_logs(parser, _report, least="*")
    logs = parser.get_default("run_command")
    parser.add_argument("--all", type=Path, metavar="DIRECTORY", help="make every page of a run or fault that is missing in a directory")
    parser.add_argument("--watch", action="store_true", help="with --all: go on, and make those of each log when it is closed")
    parser.add_argument("--run", type=COUNT, metavar="N", help="only this run")
    parser.add_argument("--no-simulation", action="store_true", help="leave out the same run on the simulated rig (quicker)")
    add_json_option(parser)
    parser.set_defaults(run_command=lambda arguments: _all(arguments) if arguments.all else logs(_named(arguments)))


def _named(arguments: argparse.Namespace) -> argparse.Namespace:
    if not arguments.logs or arguments.watch:
        what = "--watch needs --all" if arguments.watch else "no log was named"
        raise UsageError(what, where="log report", next_step="Give LOG.mcap, or --all DIRECTORY.", mend={"--all": "."})
    return arguments


def _all(arguments: argparse.Namespace) -> int:
    """At the lowest priority: it runs beside the loop."""
    from daemon.reports.missing_pages import make_missing, watch

    folder = folder_of(arguments)
    os.nice(LOWEST)
    for page in (watch if arguments.watch else make_missing)(folder, not arguments.no_simulation, _tell):
        print(json.dumps({"page": str(page)}) if arguments.json else str(page), flush=True)
    return 0


def _report(arguments: argparse.Namespace) -> int:
    from daemon.reports.run_report import write_reports

    pages = write_reports(arguments.log, None if arguments.run is None else [arguments.run], not arguments.no_simulation, _tell)
    say(arguments, {"log": arguments.log, "pages": pages}, "\n".join(map(str, pages)))
    return 0


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
