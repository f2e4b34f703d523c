"""`simulate`: the simulated arm runs a maneuver without a daemon: a log, a picture and the numbers, or a table over a sweep."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import EXIT_REFUSED, ManeuverError
from config.whole_file import refuse_existing
from daemon.cli.connection import add_json_option
from daemon.cli.operate.motion_commands import maneuver_text
from daemon.cli.options.numbers import COUNT, SEED
from daemon.cli.options.shaper import add_shaper_options, shaper_request
from daemon.cli.shown.progress import progress_lines
from daemon.cli.shown.shown_units import add_si_option, sentences_for, stated_refusals

if TYPE_CHECKING:
    from config.stated_sentences import StatedSentences
    from daemon.cli.simulate.outcome import RunOutcome
    from daemon.cli.simulate.runs import SimulatedRun, Work


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", help="rig file, or the name of a shipped rig")
    parser.add_argument("maneuver", help="maneuver file, or the name of a shipped maneuver")
    add_shaper_options(parser)
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE",
        help="change the rig (servo.rotary.gain='0.4 V/deg') or the maneuver (maneuver.y0='30 in'); may be repeated",
    )  # fmt: skip
    parser.add_argument("--repeat", type=COUNT, default=1, metavar="N", help="run the program N times (default 1)")
    parser.add_argument("--from-here", action="store_true", help="begin where the rig is; without, it first moves to the maneuver's start")
    parser.add_argument(
        "--sweep", action="append", default=[], metavar="KEY=A..B:N",
        help="a run for each of N values (KEY=A,B,C for some); KEY of the rig file, maneuver.KEY or shaper; may be repeated",
    )  # fmt: skip
    parser.add_argument("--seed", type=SEED, default=0, help="of the simulated sensors' noise (default 0)")
    parser.add_argument("-o", "--output", type=Path, default=Path("simulated.mcap"), metavar="LOG.mcap", help="default ./simulated.mcap")
    parser.add_argument("--plot", action="store_true", help="a picture beside the log")
    parser.add_argument("--processes", type=COUNT, metavar="N", help="runs of a sweep side by side (default: one a processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="run a sweep on the workers of this Dask scheduler instead")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_simulate)


def _simulate(arguments: argparse.Namespace) -> int:
    from daemon.cli.simulate.runs import SimulatedRun, all_runs
    from daemon.cli.simulate.sweep import cases

    works = _works(arguments, cases(arguments.sweep))
    if arguments.sweep:
        runs = all_runs(works, arguments.processes, arguments.dask, progress_lines(arguments.json))
    else:
        runs = [SimulatedRun({}, _outcome(works[0], arguments.si or arguments.json), "")]
    pictures = _pictures(runs) if arguments.plot else []
    if arguments.json:
        print(json.dumps({"runs": [run.as_dict() for run in runs], "pictures": pictures}))
    else:
        _show(runs, pictures, sentences_for(works[0].rig_text, arguments.si))
    return EXIT_REFUSED if any(run.refused for run in runs) else 0


def _outcome(work: Work, si: bool) -> RunOutcome:
    """Of one run; its refusal in the units of the rig file."""
    from daemon.cli.simulate.outcome import outcome
    from daemon.cli.simulate.runs import logged

    try:
        with stated_refusals(work.rig_text, si):
            return outcome(logged(work))
    except ManeuverError as error:
        if "--approach" not in error.refusal.mend:
            raise
        raise _without_from_here(error) from error


def _without_from_here(error: ManeuverError) -> ManeuverError:
    """An approach is what this command does unless it was told not to."""
    parts, advice = error.refusal, "Leave --from-here out, and it moves there first."
    mend: dict[str, str | None] = {key: value for key, value in parts.mend.items() if key != "--approach"} | {"--from-here": None}
    return ManeuverError(parts.what, value=parts.value, limit=parts.limit, unit=parts.unit, where=parts.where, next_step=advice, mend=mend)


def _works(arguments: argparse.Namespace, found: list[dict[str, str]]) -> list[Work]:
    from config.loading.load import load_rig
    from daemon.cli.simulate.runs import Work
    from daemon.cli.simulate.sweep import assignment
    from recording.files.recordings import log_name

    loaded = load_rig(arguments.rig)
    settings = dict(assignment(text) for text in arguments.set)
    request: dict[str, Any] = {
        "maneuver": maneuver_text(arguments.maneuver),
        "parameters": [],
        "shaper": shaper_request(arguments, list(loaded.rig.joints)),
        "repeat": arguments.repeat,
        "approach": not arguments.from_here,
    }
    out = log_name(arguments.output)
    names = [out] if len(found) == 1 else [out.with_name(f"{out.stem}-{k}{out.suffix}") for k in range(1, len(found) + 1)]
    for name in names:
        refuse_existing(name, "log", "Choose another name with -o; logs are never written over.", out)
    return [Work(loaded.text, loaded.path, request, name, arguments.seed, settings, case) for name, case in zip(names, found, strict=True)]


def _pictures(runs: list[SimulatedRun]) -> list[str]:
    from recording.evaluation.plots import plot_log
    from recording.files.reader import read_log

    made = []
    for run in runs:
        if run.outcome:
            picture = run.outcome.log.with_suffix(".png")
            plot_log(read_log(run.outcome.log), picture)
            made.append(str(picture))
    return made


def _show(runs: list[SimulatedRun], pictures: list[str], sentences: StatedSentences) -> None:
    from rich.console import Console

    from daemon.cli.simulate.table import below, lines, table

    if len(runs) == 1 and runs[0].outcome:
        print("\n".join(lines(runs[0].outcome)))
    else:
        Console(emoji=False, markup=False).print(table(runs))
        print("\n".join(below(runs, sentences)))
    for name in pictures:
        print(f"picture: {name}")
