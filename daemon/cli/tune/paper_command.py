"""`paper`: the 1997 paper as a test: every figure and claim computed again, as a table or as one HTML page."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from config.errors import EXIT_REFUSED, UsageError
from daemon.cli.connection import add_json_option
from daemon.cli.options.output_file import output_file

if TYPE_CHECKING:
    from config.schema.rig import Rig


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rig", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    parser.add_argument(
        "-o", "--output", type=output_file(".html"), default=Path("paper.html"), metavar="PAGE.html", help="the page (default: paper.html)"
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_paper)


def _refuse_another_arm(rig: Rig, given: str) -> None:
    from config.schema.plant_joint import Cylinder, RotaryActuator

    joints = dict(rig.plant.joints) if rig.plant else {}
    if not (isinstance(joints.get("rotary"), RotaryActuator) and isinstance(joints.get("prismatic"), Cylinder)):
        what, advice = "the paper's claims are those of a hydraulic rotary and a hydraulic prismatic joint", "Leave --rig out."
        raise UsageError(what, value=", ".join(rig.joints), where=given, next_step=advice, mend={"--rig": None})


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
    _refuse_another_arm(rig, arguments.rig)
    rows = acceptance_table(rig, say)
    if arguments.json:
        print(json.dumps([dataclasses.asdict(row) for row in rows], ensure_ascii=False))
    else:
        arguments.output.write_text(paper_page(rig, rows), encoding="utf-8")
        print(f"{sum(row.ok for row in rows)} of {len(rows)} rows hold; {arguments.output}")
    return 0 if all(row.ok for row in rows) else EXIT_REFUSED
