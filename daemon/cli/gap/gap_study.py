"""`gap study`: the same search on many pairs of logs, on this machine's processes or on a Dask cluster."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from config.errors import EXIT_UNUSABLE_DATA
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import COUNT
from daemon.cli.shown.progress import progress_lines


def register(verbs: Any) -> None:
    parser = verbs.add_parser("study", help="search many pairs of logs side by side; one folder of results a pair, and study.json")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    parser.add_argument(
        "--pair", nargs=2, type=Path, action="append", required=True, metavar=("LOG", "HOLDOUT"), help="may be repeated; named after LOG"
    )
    parser.add_argument("--out", type=Path, default=Path("gap-study"), metavar="DIR", help="where the results go (default ./gap-study)")
    parser.add_argument("--workers", type=COUNT, metavar="N", help="processes (default: one a processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="run on the workers of this Dask scheduler, e.g. tcp://host:8786, instead")
    add_json_option(parser)
    parser.set_defaults(run_command=_study)


def _study(arguments: argparse.Namespace) -> int:
    from gap.study import line, run_study, searches

    todo = searches(arguments.rig, arguments.pair, arguments.out)
    rows = run_study(todo, arguments.out, progress_lines(arguments.json), arguments.workers, arguments.dask)
    if arguments.json:
        print(json.dumps(rows))
    else:
        print("\n".join([*map(line, rows), f"written: {arguments.out / 'study.json'}"]))
    return EXIT_UNUSABLE_DATA if all(row["verdict"] == "refused" for row in rows) else 0
