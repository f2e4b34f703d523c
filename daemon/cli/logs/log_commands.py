"""`log info|check|recover|plot|diff|report|incident|export`: everything about a log that needs no daemon."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import EXIT_UNUSABLE_DATA, LogError, UsageError
from config.whole_file import refuse_existing
from daemon.cli.connection import add_json_option
from daemon.cli.logs.diff_command import options as diff_options
from daemon.cli.logs.each_log import add_logs, folder_of, say, say_refused
from daemon.cli.logs.incident_command import options as incident_options
from daemon.cli.logs.report_command import options as report_options
from daemon.cli.options.numbers import finite
from daemon.cli.options.output_file import PICTURE, output_file
from daemon.cli.shown.shown_units import add_si_option
from daemon.processes.sd_notify import notify

if TYPE_CHECKING:
    from config.schema.rig import Rig
    from recording.files.check import LogFinding
    from recording.files.reader import Log

PLOTTED = ("*.position", "*.reference", "*.command_V", "tip.*", "*_pressure_Pa", "*.pressure_?_Pa")  # where only a span is named
_REPORT = "a page for each run: reference and actual, vibration and spectra, beside the last valid run and the simulated one"
_INCIDENT = "a page for each fault: first cause, consequences in order, commands before it, the checks then, the last 30 s"
_DIFF = "what differs between two logs: rig, maneuver, filter, and every signal aligned on the start of the run (exit 1: something)"


def log_verbs(log: argparse.ArgumentParser) -> None:
    verbs = log.add_subparsers(dest="verb", required=True, metavar="VERB")
    add_si_option(_verb(verbs, "info", _info, "what is in the log: rig, runs, duration, timing"))
    check = _verb(verbs, "check", _check, "is the log whole: cycle numbers, drops, checksums, attachments (exit 3 when not)")
    check.add_argument("--rig", metavar="RIG.yaml", help="also: is it a log of this rig?")
    plot = _verb(verbs, "plot", _plot, "plot joints, commands, tip and pressures to a PNG, or chosen signals in the rig file's units")
    plot.add_argument("-o", "--output", type=PICTURE, help="the picture (default: NAME.png beside the log)")
    plot.add_argument(
        "--signals", nargs="+", metavar="GLOB", help="these columns alone, e.g. 'rotary.*' '*.command_V' tip.acceleration_mps2"
    )
    plot.add_argument("--from", dest="first_s", type=finite(), default=float("-inf"), metavar="S", help="only from this t_s on")
    plot.add_argument("--to", dest="last_s", type=finite(), default=float("inf"), metavar="S", help="only up to this t_s")
    add_si_option(plot)
    diff_options(verbs.add_parser("diff", help=_DIFF, description=_DIFF))
    report_options(verbs.add_parser("report", help=_REPORT, description=_REPORT))
    incident_options(verbs.add_parser("incident", help=_INCIDENT, description=_INCIDENT))
    export = _verb(verbs, "export", _export, "write the cycles for other programs: CSV, MATLAB or Parquet, by the ending of -o")
    export.add_argument(
        "-o",
        "--output",
        type=output_file(".csv", ".mat", ".parquet"),
        help="the table: .csv, .mat or .parquet (default: NAME.csv beside the log)",
    )
    export.add_argument("--columns", nargs="+", metavar="NAME", help="only these columns (t_s is always there)")
    _register_recover(verbs)


def _verb(verbs: Any, name: str, command: Callable[[argparse.Namespace], int], summary: str) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=summary, description=summary)
    add_logs(parser, command)
    add_json_option(parser)
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


def _beside(arguments: argparse.Namespace, ending: str) -> Path:
    chosen: Path | None = arguments.output
    return chosen or arguments.log.with_name(arguments.log.stem + ending)


def _info(arguments: argparse.Namespace) -> int:
    from daemon.reports.stated_log import sentences_of
    from recording.files.info import describe
    from recording.files.reader import read_log
    from tuning.shaper_choice.shaped_moves import shaped_moves

    log = read_log(arguments.log)
    info, shaped = describe(log), shaped_moves(log)
    answer = {**dataclasses.asdict(info), "shaped_moves": [dataclasses.asdict(move) for move in shaped]}
    text = info.text() if arguments.si else sentences_of(log).text(info.text())
    say(arguments, answer, "\n".join([text, *(f"  {move.text()}" for move in shaped)]))
    return 0


def _check(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from recording.files.check import checked
    from recording.files.reader import read_log

    rig = load_rig(arguments.rig).rig if arguments.rig else None
    log = read_log(arguments.log)
    report = checked(log, rig)
    if rig is not None and rig.plant is not None and report.good:
        report = dataclasses.replace(report, findings=(*report.findings, *_for_the_gap(log, rig)))
    say(arguments, {**dataclasses.asdict(report), "good": report.good}, report.text())
    return 0 if report.good else EXIT_UNUSABLE_DATA


def _for_the_gap(log: Log, rig: Rig) -> Iterator[LogFinding]:
    """What `longreach gap find` would refuse or warn of; a log may be whole without being of use to it."""
    from gap.data.data_check import check
    from gap.data.measured import log_columns, on_grid
    from recording.files.check import LogFinding

    try:
        problems = check([on_grid(log.path, log_columns(log, rig), rig, sha256="")], rig)
    except LogError as error:
        yield LogFinding("gap", "warning", error.refusal.what)
        return
    for problem in problems:
        yield LogFinding("gap", "warning", f"{problem.channel}: {problem.what}" if problem.channel else problem.what)


def _plot(arguments: argparse.Namespace) -> int:
    from recording.evaluation.chosen_signals import WHOLE, chosen_signals
    from recording.evaluation.panels import by_unit, write_png
    from recording.evaluation.plots import plot_log
    from recording.files.reader import read_log

    picture, log = _beside(arguments, ".png"), read_log(arguments.log)
    _tell_what_is_lost(log)
    if arguments.signals is None and (arguments.first_s, arguments.last_s) == WHOLE:
        plot_log(log, picture, arguments.si)
        say(arguments, {"picture": picture}, str(picture))
        return 0
    signals = chosen_signals(log, arguments.signals or PLOTTED, (arguments.first_s, arguments.last_s), arguments.si)
    if not signals:
        raise LogError("the signals hold no numbers here", value=" ".join(arguments.signals or PLOTTED), where=str(log.path))
    write_png(by_unit(signals), log.path.name, picture)
    say(arguments, {"picture": picture, "signals": [signal.name for signal in signals]}, str(picture))
    return 0


def _tell_what_is_lost(log: Log) -> None:
    """Of a log that was cut or is damaged: its picture and its table look whole."""
    if not log.complete:
        print(f"longreach: {log.path}: {log.cut_text}", file=sys.stderr)


def _export(arguments: argparse.Namespace) -> int:
    from recording.files.export import export
    from recording.files.reader import read_log

    table = _beside(arguments, ".csv")
    refuse_existing(table, "table", "Choose another name with -o: what stands there may be the measurement itself.")
    log = read_log(arguments.log)
    _tell_what_is_lost(log)
    rows = export(log, table, arguments.columns)
    say(arguments, {"table": table, "rows": rows}, f"{table}: {rows} rows")
    return 0


def _recover(arguments: argparse.Namespace) -> int:
    from recording.files.recordings import log_name
    from recording.files.recover import recover

    if arguments.all:
        return _recover_all(arguments)
    if arguments.log is None:
        raise UsageError("no log was named", where="log recover", next_step="Give LOG.mcap or --all DIRECTORY.", mend={"--all": "."})
    report = recover(arguments.log, log_name(_beside(arguments, "-recovered.mcap")))
    say(arguments, dataclasses.asdict(report), report.text())
    return 0


def _recover_all(arguments: argparse.Namespace) -> int:
    """Every cut log that has no repaired copy yet; a log that cannot be repaired does not keep the others from it."""
    from recording.files.recordings import logs_of
    from recording.files.recover import recover, was_closed

    status, arguments.answers = 0, []
    for log in logs_of(folder_of(arguments)):
        repaired = log.with_name(f"{log.stem}-recovered.mcap")
        if repaired.exists() or was_closed(log):
            continue
        notify(f"EXTEND_TIMEOUT_USEC={_longest_repair_us(log)}")  # or systemd would end a long repair with its time to stop
        try:
            report = recover(log, repaired)
        except LogError as error:
            say_refused(arguments, error)
            status = EXIT_UNUSABLE_DATA
            continue
        if report.written:
            say(arguments, dataclasses.asdict(report), report.text())
    if arguments.json:
        print(json.dumps(arguments.answers, default=str))
    return status


def _longest_repair_us(log: Path) -> int:
    """A megabyte a second, 25 times slower than seen."""
    return 10_000_000 + log.stat().st_size
