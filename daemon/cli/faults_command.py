"""`faults`: inject every fault into the simulated rig and measure how long it takes until the valves are safe."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from pathlib import Path
from typing import Any

from config.errors import EXIT_REFUSED, DaemonError
from daemon.cli.check_table import console
from daemon.cli.connection import add_json_option

_EPILOG = """\
Exit status 1 when a fault does not end as it must within its limit. Nothing of a running daemon or of a rig is touched: every trial has a
simulated rig, a directory and, where it needs one, a daemon of its own. See docs/faults.md.
"""


def register(commands: Any) -> None:
    parser = commands.add_parser("faults", help="inject faults into the simulated rig and measure the time to safe", epilog=_EPILOG)
    parser.add_argument("--trials", type=int, default=20, metavar="N", help="trials of each fault that the loop sees (default 20)")
    parser.add_argument("--process-trials", type=int, metavar="N", help="trials of each fault of processes (default 5, --quick 1)")
    parser.add_argument("--quick", action="store_true", help="2 trials of each fault, 1 where processes are started")
    parser.add_argument("--lockstep", action="store_true", help="only the faults that the loop sees, no processes")
    parser.add_argument("--only", action="append", default=[], metavar="WORDS", help="faults whose name has these words in it")
    parser.add_argument("--page", type=Path, metavar="FILE.md", help="write the table as a page")
    add_json_option(parser)
    parser.set_defaults(run_command=_faults)


def _faults(arguments: argparse.Namespace) -> int:
    from daemon.faults import matrix, report  # here, because the simulation would slow down every other command

    chosen = [
        fault
        for fault in matrix.all_faults(processes=not arguments.lockstep)
        if not arguments.only or any(words in fault.name for words in arguments.only)
    ]
    if not chosen:
        raise DaemonError("no fault has these words in its name", value=", ".join(arguments.only))
    trials = matrix.QUICK_TRIALS if arguments.quick else arguments.trials
    process_trials = arguments.process_trials or (1 if arguments.quick else matrix.PROCESS_TRIALS)
    rows = []
    for row in matrix.run_matrix(chosen, trials, process_trials):
        rows.append(row)
        print(f"{'ok' if row.ok else 'NO'}  {'  '.join(report.cells(row))}", file=sys.stderr, flush=True)
    if arguments.json:
        print(json.dumps([row.as_dict() for row in rows]))
    else:
        console().print(report.table(rows))
    if arguments.page:
        arguments.page.write_text(report.page(rows, _command(arguments)), encoding="utf-8")
    return 0 if all(row.ok for row in rows) else EXIT_REFUSED


def _command(arguments: argparse.Namespace) -> str:
    words = ["longreach", "faults", "--trials", str(arguments.trials)]
    words += ["--process-trials", str(arguments.process_trials)] if arguments.process_trials else []
    words += [f"--{name}" for name in ("quick", "lockstep") if getattr(arguments, name)]
    words += [word for only in arguments.only for word in ("--only", only)]
    return shlex.join([*words, "--page", str(arguments.page)])
