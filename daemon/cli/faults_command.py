"""`faults`: inject every fault into the simulated rig and measure how long it takes until the valves are safe."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from config.errors import EXIT_REFUSED, UsageError
from config.parsing.nearest import nearest
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import COUNT
from daemon.cli.options.output_file import output_file

if TYPE_CHECKING:
    from daemon.faults.fault import Fault, FaultRow

_EPILOG = """\
Exit status 1 when a fault does not end as it must within its limit. Nothing of a running daemon or of a rig is touched: every trial has a
simulated rig, a directory and, where it needs one, a daemon of its own. Faults in the twin need a network namespace (root), and are
skipped with the reason where none can be made. See docs/results/faults.md.
"""


def options(parser: argparse.ArgumentParser) -> None:
    parser.epilog = _EPILOG
    parser.add_argument("--trials", type=COUNT, default=20, metavar="N", help="trials of each fault that the loop sees (default 20)")
    parser.add_argument("--slow-trials", type=COUNT, metavar="N", help="trials of each of the others (default 5, --quick 1)")
    parser.add_argument("--quick", action="store_true", help="2 trials of each fault, 1 on the wall clock")
    places = ("loop", "processes", "twin")
    parser.add_argument("--where", action="append", choices=places, help="only faults injected there (may be given again)")
    parser.add_argument("--only", action="append", default=[], metavar="WORDS", help="faults whose name has these words in it")
    parser.add_argument("--median", action="store_true", help="repeat what is not ok, and let most of its trials decide")
    parser.add_argument(
        "--keep", type=output_file(".json"), metavar="FILE.json", help="add the measurements to this file; what is there is not repeated"
    )
    parser.add_argument("--page", type=output_file(".md"), metavar="FILE.md", help="write the table as a page")
    add_json_option(parser)
    parser.set_defaults(run_command=_faults)


def _faults(arguments: argparse.Namespace) -> int:
    from daemon.cli.shown.rich_console import console
    from daemon.faults import report

    rows = _measured(arguments)
    if arguments.json:
        print(json.dumps([row.as_dict() for row in rows]))
    else:
        console().print(report.table(rows))
    if arguments.page:
        arguments.page.write_text(report.page(rows, _command(arguments)), encoding="utf-8")
    return 0 if all(row.ok for row in rows) else EXIT_REFUSED


def _measured(arguments: argparse.Namespace) -> list[FaultRow]:
    """The chosen rows of the matrix, each shown and kept as it is done."""
    from daemon.faults import matrix, report, trial_file
    from daemon.faults.benches.process_bench import ProcessBench
    from daemon.faults.benches.twin_bench import TwinBench
    from daemon.faults.fault import FaultPlace

    trials = matrix.QUICK_TRIALS if arguments.quick else arguments.trials
    slow = arguments.slow_trials or (1 if arguments.quick else matrix.SLOW_TRIALS)
    numbers = {FaultPlace.LOOP: trials, FaultPlace.PROCESSES: slow, FaultPlace.TWIN: slow}
    rows = []
    with ProcessBench() as processes, TwinBench(processes.end) as twin:
        chosen = _chosen(matrix.all_faults(processes, twin), arguments)
        before = trial_file.read(arguments.keep) if arguments.keep else {}
        for row in matrix.run_matrix(chosen, numbers, arguments.median, before):
            rows.append(row)
            print(f"{'ok' if row.ok else 'NO'}  {'  '.join(report.cells(row))}", file=sys.stderr, flush=True)
            if arguments.keep:
                trial_file.add(arguments.keep, row)
    return rows


def _chosen(faults: Sequence[Fault], arguments: argparse.Namespace) -> list[Fault]:
    chosen = [
        fault
        for fault in faults
        if (not arguments.where or fault.where in arguments.where)
        and (not arguments.only or any(words in fault.name for words in arguments.only))
    ]
    if not chosen:
        names = sorted(fault.name for fault in faults)
        mend = {word: near for word in arguments.only if (near := nearest(word, names))}
        advice = f"There are: {'; '.join(names)}."
        raise UsageError("no fault has these words in its name", value=", ".join(arguments.only), next_step=advice, mend=mend)
    return chosen


def _command(arguments: argparse.Namespace) -> str:
    words = ["longreach", "faults", "--trials", str(arguments.trials)]
    words += ["--slow-trials", str(arguments.slow_trials)] if arguments.slow_trials else []
    words += [f"--{name}" for name in ("quick", "median") if getattr(arguments, name)]
    words += [word for where in arguments.where or [] for word in ("--where", where)]
    words += [word for only in arguments.only for word in ("--only", only)]
    return shlex.join([*words, "--page", str(arguments.page)])
