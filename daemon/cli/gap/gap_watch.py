"""`gap watch`: what wear and faults change, over the logs of weeks."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daemon.cli.connection import add_json_option
from daemon.cli.dates import moment
from daemon.cli.options.numbers import COUNT
from daemon.cli.shown.progress import progress_lines

if TYPE_CHECKING:
    from gap.watch.watch import Watch

NOTE = "Exit status: 0 whatever the numbers do (an alarm is a result: `alarms` in watch.json), 3 where no log can be used."


def register(verbs: Any) -> None:
    parser = verbs.add_parser(
        "watch", help="follow friction, leakage, valve gain … over the logs of weeks; writes watch.html and watch.json", epilog=NOTE
    )
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    parser.add_argument(
        "--logs", required=True, type=Path, metavar="DIR", help="folder of logs (MCAP; CSV and MAT with a date in their names)"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("gap-watch"), metavar="DIR", help="page, numbers and the fit of each log (default ./gap-watch)"
    )
    parser.add_argument("--since", metavar="DATE", help="only logs that began then or later, UTC: 2026-05-31, 2026-05-31T14:00")
    parser.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="how far a number may go, e.g. axis.coulomb_friction.friction='80 N' (bare: in the rig file's unit); an upper limit above the "
        "rig file's value, a lower one below it; may be repeated (default, also of the other side: 3 standard deviations of its tag)",
    )
    parser.add_argument("--workers", type=COUNT, metavar="N", help="processes (default: one a processor)")
    add_json_option(parser)
    parser.set_defaults(run_command=_watch)


def _watch(arguments: argparse.Namespace) -> int:
    from gap.watch.watch import watch

    found = watch(
        arguments.rig,
        arguments.logs,
        arguments.out,
        progress_lines(arguments.json),
        moment(arguments.since, "--since"),
        arguments.limit,
        arguments.workers,
    )
    print(json.dumps(found.as_dict(), allow_nan=False) if arguments.json else summary(found, arguments.out))
    return 0


def summary(found: Watch, out: Path) -> str:
    """What a reader at the terminal needs, in the units of the rig file."""
    from gap.outcome.file_units import FileUnits
    from gap.watch.page import headline, now, said

    units = FileUnits(found.rig.text)
    what, span = headline(found.numbers, found.fits)
    lines = [f"{what}; {span}"]
    for one in found.numbers:
        if one.course is not None:
            shown = units.constant(one.number.free.key, one.number.free.unit)
            lines.append(f"  {one.number.name}: {now(one, shown)}, rig file {shown.text(one.number.free.start)}: {said(one)}")
    unknown = [one.number.name for one in found.numbers if one.course is None]
    lines += [f"unknown: {', '.join(unknown)}"] if unknown else []
    lines += [f"not used: {one.path.name}: {one.why}. {one.next_step}" for one in found.unusable]
    return "\n".join([*lines, f"written: {out / 'watch.html'}, {out / 'watch.json'}"])
