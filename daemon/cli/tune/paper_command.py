"""`paper`: the 1997 paper as a test: every figure and claim computed again, as a table or as one HTML page."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path

from config.errors import EXIT_REFUSED
from daemon.cli.connection import add_json_option


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rig", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    parser.add_argument("-o", "--output", type=Path, default=Path("paper.html"), metavar="PAGE.html", help="the page (default: paper.html)")
    add_json_option(parser)
    parser.set_defaults(run_command=_paper)


def _paper(arguments: argparse.Namespace) -> int:
    """With --json only the rows are computed and printed; else also the figures, into the page."""
    from config.loading.load import load_rig
    from tuning.paper.page import paper_page
    from tuning.paper.row import ClaimRow
    from tuning.paper.table import acceptance_table

    def say(row: ClaimRow) -> None:
        if not arguments.json:
            print(f"{row.row:3} {'ok  ' if row.ok else 'FAIL'} {row.claim}: {row.measured}", file=sys.stderr)

    rig = load_rig(arguments.rig).rig
    rows = acceptance_table(rig, say)
    if arguments.json:
        print(json.dumps([dataclasses.asdict(row) for row in rows], ensure_ascii=False))
    else:
        arguments.output.write_text(paper_page(rig, rows), encoding="utf-8")
        print(f"{sum(row.ok for row in rows)} of {len(rows)} rows hold; {arguments.output}")
    return 0 if all(row.ok for row in rows) else EXIT_REFUSED
