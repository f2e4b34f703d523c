"""A verb for one log, applied to all that were named: one that cannot be used does not keep the others from it."""

from __future__ import annotations

import argparse
import json
import os
import shlex
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from config.errors import LogError, LongreachError, UsageError
from daemon.cli.refusal import error_object

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
    answers: list[Any] = []
    status = max(_one(arguments, log, verb, answers) for log in logs)
    if arguments.json:
        print(json.dumps(answers, default=str))
    return status


def say(arguments: argparse.Namespace, answer: Mapping[str, Any], text: str) -> None:
    """What a verb found of one log; as JSON it is put beside that of the other logs, if there are any."""
    answers: list[Any] | None = getattr(arguments, "answers", None)
    if not arguments.json:
        print(text)
    elif answers is None:
        print(json.dumps(answer, default=str))
    else:
        answers.append(answer)


def say_refused(arguments: argparse.Namespace, error: LongreachError) -> None:
    """Of one log among several."""
    if arguments.json:
        arguments.answers.append(error_object(error))
    else:
        print(f"longreach: {error}", file=sys.stderr)


def folder_of(arguments: argparse.Namespace) -> Path:
    """What --all names. UsageError for a log: it is named without."""
    folder: Path = arguments.all
    if os.path.isfile(folder):
        advice = f"For one log: `{shlex.join(['longreach', 'log', arguments.verb, str(folder)])}`."
        raise UsageError("--all takes a folder of logs", value=str(folder), where=f"log {arguments.verb}", next_step=advice)
    return folder


def _one(arguments: argparse.Namespace, log: Path, verb: Verb, answers: list[Any]) -> int:
    of_this = argparse.Namespace(**vars(arguments), log=log, answers=answers)
    try:
        return verb(of_this)
    except (LogError, UsageError) as error:
        say_refused(of_this, error)
        return error.exit_status
