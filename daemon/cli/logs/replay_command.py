"""`replay`: re-execute the controller from the log alone, or with one thing changed."""

from __future__ import annotations

import argparse
import dataclasses

from daemon.cli.connection import add_json_option
from daemon.cli.logs.each_log import add_logs, say


def options(parser: argparse.ArgumentParser) -> None:
    add_logs(parser, _replay)
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="re-execute with a change, e.g. --set servo.rotary.gain='0.5 V/deg'"
    )
    add_json_option(parser)


def _replay(arguments: argparse.Namespace) -> int:
    """Exit 0 when bit-identical (or when a difference was asked for with --set), 1 when it diverges or cycles are missing between."""
    from recording.evaluation.replay import reexecute

    result = reexecute(arguments.log, tuple(arguments.set))
    text = result.text() if len(arguments.logs) == 1 else f"{arguments.log}: {result.text()}"
    say(arguments, dataclasses.asdict(result), text)
    return 0 if result.identical or arguments.set else 1
