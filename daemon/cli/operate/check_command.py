"""`check RIG.yaml`: everything that can be known about a rig file without hardware."""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import json
import sys
from typing import TYPE_CHECKING

from config.errors import EXIT_REFUSED, ConfigError
from daemon.cli.connection import add_json_option
from daemon.cli.shown.shown_units import add_si_option, sentences_for

if TYPE_CHECKING:
    from collections.abc import Sequence

    from config.checking.finding import Finding
    from config.loading.load import LoadedRig
    from config.migrating.migrate_file import MigratedFile

_STYLE = {"ok": "[green]ok[/]", "warning": "[yellow]warning[/]", "error": "[red bold]error[/]"}


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", metavar="RIG.yaml", help="a rig file, or the name of a shipped rig")
    parser.add_argument(
        "--migrate", action="store_true", help="first rewrite the keys of older versions in the file; comments stay, a copy is kept"
    )
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_check)


def _check(arguments: argparse.Namespace) -> int:
    from config.checking.check import check_rig
    from config.loading.load import load_rig

    moved = _migrate(arguments) if arguments.migrate else None
    try:
        loaded = load_rig(arguments.rig)
    except ConfigError:
        _tell_older_keys(arguments)
        raise
    findings = check_rig(loaded, datetime.date.today())
    errors = [finding for finding in findings if finding.level == "error"]
    if arguments.json:
        told = [{"level": each.level, "text": each.text} for each in findings]
        answer = {"rig": loaded.rig.name, "good": not errors, "findings": told}
        print(json.dumps(answer | ({"migrated": dataclasses.asdict(moved)} if moved else {}), default=str))
    else:
        _show(loaded, findings, arguments.si)
    return EXIT_REFUSED if errors else 0


def _show(loaded: LoadedRig, findings: Sequence[Finding], si: bool) -> None:
    from rich.table import Table
    from rich.text import Text

    from daemon.cli.shown.rich_console import console

    title = Text(f"{loaded.path}: {loaded.rig.name}", style="italic")
    table = Table(title=title, title_justify="left", show_header=False)
    sentences = sentences_for(loaded.text, si)
    for finding in findings:
        shown = Text(sentences.text(finding.text))  # as it is: brackets and colons are no markup
        table.add_row(_STYLE[finding.level], shown)
    console().print(table)


def _migrate(arguments: argparse.Namespace) -> MigratedFile:
    from config.loading.shipped import find
    from config.migrating.migrate_file import migrate_file

    moved = migrate_file(find("rigs", arguments.rig))
    if not arguments.json:
        print(moved.text())
    return moved


def _tell_older_keys(arguments: argparse.Namespace) -> None:
    """Before the problems of a file are told: those that --migrate would solve."""
    from config.loading.load import find, read_text
    from config.migrating.migrations import migrated

    try:
        done = migrated(read_text(find("rigs", arguments.rig)))[1]
    except ConfigError:
        return
    for each in done:
        print(f"an older key: {each.text()}", file=sys.stderr)
    if done:
        print(f"`longreach check {arguments.rig} --migrate` rewrites them and keeps a copy", file=sys.stderr)
