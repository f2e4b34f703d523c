"""`import`: measured tables become logs; `--suggest` proposes the map that says what their columns are."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path

from config.errors import UsageError
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import finite


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("table", type=Path, metavar="DATA", help="a table with column names: CSV (comma, semicolon, tab) or MATLAB .mat")
    parser.add_argument("--map", metavar="MAP.yaml", help="renames columns and converts units; a file or the name of a shipped map")
    parser.add_argument("--rig", metavar="RIG.yaml", help="the rig the data are from: goes into the log, and its joints must be the data's")
    parser.add_argument("--from", dest="first_s", type=finite(), action="append", default=[], metavar="S", help="only from this t_s on")
    parser.add_argument("--to", dest="last_s", type=finite(), action="append", default=[], metavar="S", help="only up to this t_s")
    parser.add_argument("--suggest", action="store_true", help="print a map proposed from the column names, and write no log")
    parser.add_argument("-o", "--output", type=Path, metavar="LOG.mcap", help="the log; NAME-1, NAME-2 … where gaps or spans make several")
    add_json_option(parser)
    parser.epilog = "--from and --to may be repeated, in pairs, for several parts of one table."
    parser.set_defaults(run_command=_import)


def _import(arguments: argparse.Namespace) -> int:
    if arguments.suggest:
        return _suggest(arguments)
    from config.loading.load import load_rig
    from config.loading.shipped import find
    from recording.files.recordings import log_name
    from recording.importing.ingest import ingest_parts

    if arguments.output is None:
        advice, mend = "Add -o LOG.mcap, or --suggest to see a map first.", {"-o": f"{arguments.table.stem}.mcap"}
        raise UsageError("no log was named", where="import", next_step=advice, mend=mend)
    chosen = find("maps", arguments.map) if arguments.map else None
    rig = load_rig(arguments.rig) if arguments.rig else None
    reports = ingest_parts(arguments.table, chosen, log_name(arguments.output), rig, _spans(arguments))
    if arguments.json:
        print(json.dumps([dataclasses.asdict(report) for report in reports], default=str))
    else:
        print("\n".join(report.text() for report in reports))
    return 0


def _spans(arguments: argparse.Namespace) -> list[tuple[float, float]]:
    """Pairs of --from and --to; where one is left out, the table's end stands for it."""
    first, last = arguments.first_s, arguments.last_s
    if len(first) > 1 or len(last) > 1:
        if len(first) != len(last):
            counts = f"{len(first)} --from, {len(last)} --to"
            raise UsageError("parts need a --from and a --to each", value=counts, where="import", next_step="Give them in pairs.")
        return list(zip(first, last, strict=True))
    return [(*(first or [float("-inf")]), *(last or [float("inf")]))] if first or last else []


def _suggest(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from recording.importing.read_table import read_table
    from recording.importing.suggestion import suggested_map

    rig = load_rig(arguments.rig).rig if arguments.rig else None
    joints: dict[str, str] = {name: str(joint.motion) for name, joint in rig.joints.items()} if rig else {"axis": "linear"}
    text = suggested_map(read_table(arguments.table), arguments.table.stem, rig.name if rig else "", joints)
    print(json.dumps({"map": text}) if arguments.json else text, end="\n" if arguments.json else "")
    return 0
