"""`log info|check|recover|plot|export` and `import`: everything about a log that needs no daemon."""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from config.errors import EXIT_UNUSABLE_DATA, LogError
from config.load import load_rig
from config.shipped import find
from daemon.cli.connection import add_json_option
from daemon.notify import notify
from recording.check import check_log
from recording.export import export_csv
from recording.info import describe
from recording.ingest import ingest
from recording.plots import plot_log
from recording.reader import read_log
from recording.recover import recover, was_closed


def register(commands: Any) -> None:
    log = commands.add_parser("log", help="look at, check, repair, plot or export a log")
    verbs = log.add_subparsers(dest="verb", required=True, metavar="VERB")
    _verb(verbs, "info", _info, "what is in the log: rig, runs, duration, timing")
    check = _verb(verbs, "check", _check, "is the log whole: cycle numbers, drops, checksums, attachments (exit 3 when not)")
    check.add_argument("--rig", metavar="RIG.yaml", help="also: is it a log of this rig?")
    plot = _verb(verbs, "plot", _plot, "plot joints, commands, tip and pressures to a PNG")
    plot.add_argument("-o", "--output", type=Path, help="the picture (default: NAME.png beside the log)")
    export = _verb(verbs, "export", _export, "write the cycles as CSV with the contract's column names")
    export.add_argument("-o", "--output", type=Path, help="the CSV (default: NAME.csv beside the log)")
    export.add_argument("--columns", nargs="+", metavar="NAME", help="only these columns (t_s is always there)")
    _register_recover(verbs)
    _register_import(commands)


def _verb(verbs: Any, name: str, command: Callable[[argparse.Namespace], int], summary: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=summary, description=summary)
    parser.add_argument("log", type=Path, metavar="LOG.mcap")
    add_json_option(parser)
    parser.set_defaults(run_command=command)
    return parser


def _register_recover(verbs: Any) -> None:
    parser = verbs.add_parser("recover", help="repair a log that was cut, into a new file")
    parser.add_argument("log", type=Path, nargs="?", metavar="LOG.mcap")
    parser.add_argument("-o", "--output", type=Path, help="the repaired log (default: NAME-recovered.mcap beside it)")
    parser.add_argument(
        "--all", type=Path, metavar="DIRECTORY", help="repair every cut log in a directory (the service does this when it stops)"
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_recover)


def _register_import(commands: Any) -> None:
    parser = commands.add_parser("import", help="turn measured CSV data from anywhere into a log")
    parser.add_argument("csv", type=Path, metavar="DATA.csv")
    parser.add_argument("--map", metavar="MAP.yaml", help="renames columns and converts units; a file or the name of a shipped map")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="LOG.mcap")
    add_json_option(parser)
    parser.set_defaults(run_command=_import)


def _beside(arguments: argparse.Namespace, ending: str) -> Path:
    chosen: Path | None = arguments.output
    return chosen or arguments.log.with_name(arguments.log.stem + ending)


def _say(arguments: argparse.Namespace, answer: dict[str, Any], text: str) -> None:
    print(json.dumps(answer, default=str) if arguments.json else text)


def _info(arguments: argparse.Namespace) -> int:
    from tuning.shaped_moves import shaped_moves  # scipy is only loaded for this verb

    log = read_log(arguments.log)
    info, shaped = describe(log), shaped_moves(log)
    answer = {**dataclasses.asdict(info), "shaped_moves": [dataclasses.asdict(move) for move in shaped]}
    _say(arguments, answer, "\n".join([info.text(), *(f"  {move.text()}" for move in shaped)]))
    return 0


def _check(arguments: argparse.Namespace) -> int:
    report = check_log(arguments.log, load_rig(arguments.rig).rig if arguments.rig else None)
    _say(arguments, {**dataclasses.asdict(report), "good": report.good}, report.text())
    return 0 if report.good else EXIT_UNUSABLE_DATA


def _plot(arguments: argparse.Namespace) -> int:
    picture = _beside(arguments, ".png")
    plot_log(read_log(arguments.log), picture)
    _say(arguments, {"picture": picture}, str(picture))
    return 0


def _export(arguments: argparse.Namespace) -> int:
    table = _beside(arguments, ".csv")
    rows = export_csv(read_log(arguments.log), table, arguments.columns)
    _say(arguments, {"csv": table, "rows": rows}, f"{table}: {rows} rows")
    return 0


def _recover(arguments: argparse.Namespace) -> int:
    if arguments.all:
        return _recover_all(arguments)
    if arguments.log is None:
        raise LogError("no log was named", where="log recover", next_step="Give LOG.mcap or --all DIRECTORY.")
    report = recover(arguments.log, _beside(arguments, "-recovered.mcap"))
    _say(arguments, dataclasses.asdict(report), report.text())
    return 0


def _recover_all(arguments: argparse.Namespace) -> int:
    """Every cut log that has no repaired copy yet; a log that cannot be repaired does not keep the others from it."""
    status = 0
    for log in sorted(arguments.all.glob("*.mcap")):
        repaired = log.with_name(f"{log.stem}-recovered.mcap")
        if repaired.exists() or was_closed(log):
            continue
        notify(f"EXTEND_TIMEOUT_USEC={_longest_repair_us(log)}")  # or systemd would end a long repair with its time to stop
        try:
            report = recover(log, repaired)
        except LogError as error:
            print(f"longreach: {error}")
            status = EXIT_UNUSABLE_DATA
            continue
        if report.written:
            _say(arguments, dataclasses.asdict(report), report.text())
    return status


def _longest_repair_us(log: Path) -> int:
    """A megabyte a second, 25 times slower than seen."""
    return 10_000_000 + log.stat().st_size


def _import(arguments: argparse.Namespace) -> int:
    chosen = find("maps", arguments.map) if arguments.map else None
    report = ingest(arguments.csv, chosen, arguments.output)
    _say(arguments, dataclasses.asdict(report), report.text())
    return 0
