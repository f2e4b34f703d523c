"""`runs`: the runs in a folder of logs, filtered by rig, maneuver, filter, date, validity and residual vibration."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from config.errors import LogError
from daemon.cli.connection import add_json_option
from daemon.cli.dates import moment
from daemon.cli.options.numbers import COUNT, finite

if TYPE_CHECKING:
    from recording.files.catalogue import Recorded
    from recording.files.info import RunFacts


class Listed(NamedTuple):
    """`vibration_mps2`: rms over the run's holds; None where it was not measured or not asked for."""

    log: Recorded
    run: RunFacts
    started: datetime
    vibration_mps2: float | None = None


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "places", type=Path, nargs="*", metavar="FOLDER", help="folders of logs, or logs (default: where the daemon writes)"
    )
    parser.add_argument("--rig", metavar="GLOB", default="*", help="only runs of these rigs, e.g. 'ornl*'")
    parser.add_argument("--maneuver", metavar="GLOB", default="*", help="only these maneuvers, e.g. 'paper_line*'")
    parser.add_argument("--shaper", metavar="GLOB", default="*", help="only runs with these filters")
    kinds = parser.add_mutually_exclusive_group()
    kinds.add_argument("--valid", action="store_true", help="only valid runs")
    kinds.add_argument("--invalid", action="store_true", help="only runs that are not valid")
    parser.add_argument("--since", metavar="DATE", help="only runs that began then or later, UTC: 2026-05-31, 2026-05-31T14:00")
    parser.add_argument("--until", metavar="DATE", help="only runs that began up to then; a bare date means all of that day")
    parser.add_argument("--vibration", action="store_true", help="show what vibration was left (rms of the holds, m/s²)")
    parser.add_argument("--vibration-above", type=finite(), metavar="MPS2", help="only runs that left more than this")
    parser.add_argument("--vibration-below", type=finite(), metavar="MPS2", help="only runs that left less than this")
    parser.add_argument("--last", type=COUNT, metavar="N", help="only the newest N")
    add_json_option(parser)
    parser.set_defaults(run_command=_runs)


def _runs(arguments: argparse.Namespace) -> int:
    from recording.files.catalogue import logs_in

    logs = list(_recorded(logs_in(arguments.places or [_usual_place()])))
    found = list(_chosen(arguments, logs))
    found.sort(key=lambda each: (each.started, each.log.path.name, each.run.number))
    if arguments.vibration or arguments.vibration_above is not None or arguments.vibration_below is not None:
        found = list(_with_vibration(arguments, found))
    found = found if arguments.last is None else found[-arguments.last :]
    if arguments.json:
        print(json.dumps([_as_dict(each) for each in found]))
    elif found:
        _print(found)
    else:
        print(_none_of(arguments, logs))
    return 0


def _none_of(arguments: argparse.Namespace, logs: Sequence[Recorded]) -> str:
    """Why no run is shown: there is none, or none is like an option wants it."""
    runs = [(log.rig_name, run.maneuver, run.shaper) for log in logs for run in log.runs]
    if not runs:
        return "no run: `longreach runs FOLDER` lists those of another folder"
    for name, there in zip(("rig", "maneuver", "shaper"), map(set, zip(*runs, strict=True)), strict=True):
        wanted = getattr(arguments, name)
        if not any(fnmatchcase(value, wanted) for value in there):
            return f"{len(runs)} runs, none with --{name} {wanted} (there are: {', '.join(sorted(there))})"
    return f"{len(runs)} runs, none of which all options allow"


def _usual_place() -> Path:
    from daemon.processes.paths import log_directory

    return log_directory()


def _recorded(logs: Iterable[Path]) -> Iterator[Recorded]:
    """A log that cannot be used is told and left out."""
    from recording.files.catalogue import recorded

    for path in logs:
        try:
            yield recorded(path)
        except LogError as error:
            print(f"longreach: {error}", file=sys.stderr)


def _chosen(arguments: argparse.Namespace, logs: Iterable[Recorded]) -> Iterator[Listed]:
    since, until = moment(arguments.since, "--since"), moment(arguments.until, "--until", end=True)
    for log in logs:
        for run in log.runs:
            started = log.begun[run.number]
            if not all(
                fnmatchcase(value, pattern)
                for value, pattern in ((log.rig_name, arguments.rig), (run.maneuver, arguments.maneuver), (run.shaper, arguments.shaper))
            ):
                continue
            if (arguments.valid and not run.valid) or (arguments.invalid and run.valid):
                continue
            if (since and started < since) or (until and started >= until):
                continue
            yield Listed(log, run, started)


def _with_vibration(arguments: argparse.Namespace, found: list[Listed]) -> Iterator[Listed]:
    from recording.evaluation.kept_vibration import residual_vibration

    logs = list(dict.fromkeys(each.log.path for each in found))
    left = residual_vibration(logs, lambda line: print(line, file=sys.stderr, flush=True))
    above, below = arguments.vibration_above, arguments.vibration_below
    for each in found:
        value = left[each.log.path].get(each.run.number)
        if (above is None or (value is not None and value > above)) and (below is None or (value is not None and value < below)):
            yield each._replace(vibration_mps2=value)


def _as_dict(each: Listed) -> dict[str, Any]:
    run = each.run
    return {
        "log": str(each.log.path), "rig": each.log.rig_name, "run": run.number, "maneuver": run.maneuver, "shaper": run.shaper,
        "started_utc": each.started.isoformat(), "start_t_s": run.start_t_s, "duration_s": run.duration_s,
        "valid": run.valid, "reason": run.reason, "vibration_mps2": each.vibration_mps2, "complete": each.log.complete,
        "recovered": each.log.recovered, "ended_by": each.log.ended_by,
    }  # fmt: skip


def _print(found: list[Listed]) -> None:
    for each in found:
        run = each.run
        left = "" if each.vibration_mps2 is None else f"  {each.vibration_mps2:.3f} m/s² left"
        verdict = ("valid" if run.valid else f"not valid: {run.reason}") + (", in a recovered log" if each.log.recovered else "")
        print(
            f"{each.started:%Y-%m-%d %H:%M:%S}  {each.log.rig_name}  {run.maneuver}, {run.shaper}, {run.duration_s:.1f} s{left}  {verdict}"
        )
        print(f"    {each.log.path}, run {run.number}")
