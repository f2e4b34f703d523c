"""`check RIG.yaml`: everything that can be known about a rig file without hardware."""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import json
from typing import Any

from rich.table import Table

from config.check import check_rig
from config.errors import EXIT_REFUSED
from config.load import load_rig
from daemon.cli.check_table import console
from daemon.cli.connection import add_json_option

_STYLE = {"ok": "[green]ok[/]", "warning": "[yellow]warning[/]", "error": "[red bold]error[/]"}


def register(commands: Any) -> None:
    parser = commands.add_parser("check", help="check a rig file, with no hardware")
    parser.add_argument("rig", metavar="RIG.yaml", help="a rig file, or the name of a shipped rig")
    add_json_option(parser)
    parser.set_defaults(run_command=_check)


def _check(arguments: argparse.Namespace) -> int:
    loaded = load_rig(arguments.rig)
    findings = check_rig(loaded, datetime.date.today())
    errors = [finding for finding in findings if finding.level == "error"]
    if arguments.json:
        print(json.dumps({"rig": loaded.rig.name, "good": not errors, "findings": [dataclasses.asdict(each) for each in findings]}))
        return EXIT_REFUSED if errors else 0
    table = Table(title=f"{loaded.path}: {loaded.rig.name}", title_justify="left", show_header=False)
    for finding in findings:
        table.add_row(_STYLE[finding.level], finding.text)
    console().print(table)
    return EXIT_REFUSED if errors else 0
