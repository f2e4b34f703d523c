"""`log diff A B`: what differs between two logs, in numbers and as a picture."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from config.errors import EXIT_REFUSED
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import COUNT
from daemon.cli.options.output_file import PICTURE
from daemon.cli.shown.shown_units import add_si_option


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", type=Path, metavar="A.mcap")
    parser.add_argument("b", type=Path, metavar="B.mcap")
    parser.add_argument(
        "--runs", type=COUNT, nargs=2, metavar=("M", "N"), help="compare run M of A with run N of B (default: the first of each)"
    )
    parser.add_argument("-o", "--output", type=PICTURE, metavar="PICTURE.png", help="the picture (default: A-B.png beside A)")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_diff)


def _diff(arguments: argparse.Namespace) -> int:
    """Exit 0 when nothing differs, 1 when something does."""
    from recording.evaluation.log_difference import difference
    from recording.evaluation.panels import write_png
    from recording.files.reader import read_log

    found = difference(read_log(arguments.a), read_log(arguments.b), tuple(arguments.runs) if arguments.runs else None, arguments.si)
    picture = None
    if panels := found.panels():
        picture = arguments.output or arguments.a.with_name(f"{arguments.a.stem}-{arguments.b.stem}.png")
        write_png(panels, f"A {arguments.a.name}, B {arguments.b.name}", picture, "time since the run began / s")
    if arguments.json:
        print(json.dumps({**found.as_dict(), "picture": picture}, default=str))
    else:
        print(found.text() + (f"\npicture: {picture}" if picture else ""))
    return 0 if found.same else EXIT_REFUSED
