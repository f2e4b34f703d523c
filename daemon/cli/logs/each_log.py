"""A verb for one log, applied to all that were named: one that cannot be used does not keep the others from it."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from collections.abc import Callable
from pathlib import Path

from config.errors import LogError, UsageError

Verb = Callable[[argparse.Namespace], int]


def add_logs(parser: argparse.ArgumentParser, verb: Verb, least: str = "+") -> None:
    """`LOG.mcap …` as positional arguments (`least`: "*" where there may be none); `verb` gets each as `arguments.log`. Of exit statuses
    the largest counts."""
    parser.add_argument("logs", type=Path, nargs=least, metavar="LOG.mcap")
    parser.set_defaults(run_command=lambda arguments: _each(arguments, verb))


def _each(arguments: argparse.Namespace, verb: Verb) -> int:
    logs: list[Path] = arguments.logs
    if len(logs) == 1:
        return verb(argparse.Namespace(**vars(arguments), log=logs[0]))
    if getattr(arguments, "output", None):
        advice = "Leave -o away: each output stands beside its log."
        raise UsageError(
            "one output cannot hold several logs", value=str(arguments.output), where="-o", next_step=advice, mend={"-o": None}
        )
    return max(_one(arguments, log, verb) for log in logs)


def folder_of(arguments: argparse.Namespace) -> Path:
    """What --all names. UsageError for a log: it is named without."""
    folder: Path = arguments.all
    if os.path.isfile(folder):
        advice = f"For one log: `{shlex.join(['longreach', 'log', arguments.verb, str(folder)])}`."
        raise UsageError("--all takes a folder of logs", value=str(folder), where=f"log {arguments.verb}", next_step=advice)
    return folder


def _one(arguments: argparse.Namespace, log: Path, verb: Verb) -> int:
    try:
        return verb(argparse.Namespace(**vars(arguments), log=log))
    except (LogError, UsageError) as error:
        print(f"longreach: {error}", file=sys.stderr)
        return error.exit_status
