"""Runs the command that was named and turns errors into exits; `commands` lists them all.

Exit statuses: 0 done, 1 refused (with the reason), 2 wrong usage, 3 unusable data, 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence

from config.errors import EXIT_REFUSED, LongreachError
from config.whole_file import refused_by_system
from daemon.cli.commands import Parser, add_commands
from daemon.cli.refusal import report

RunCommand = Callable[[argparse.Namespace], int]


def build_parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="longreach",
        description="Controller for hydraulic long-reach arms: check a rig, run maneuvers, look at logs.",
        epilog="Commands that talk to the daemon find it through --socket, $LONGREACH_SOCKET or the usual place. See docs/.",
    )
    parser.add_argument("--socket", help="the daemon's Unix socket")
    add_commands(parser)
    return parser


def run(words: Sequence[str]) -> int:
    """Run one command; returns the exit status."""
    arguments = build_parser().parse_args(words)
    command: RunCommand = arguments.run_command
    try:
        return command(arguments)
    except BrokenPipeError:
        return EXIT_REFUSED
    except (LongreachError, OSError) as error:
        refusal = error if isinstance(error, LongreachError) else refused_by_system(error)
        report(refusal, words, arguments)
        return refusal.exit_status
    except KeyboardInterrupt:
        print("interrupted; the daemon goes on: `longreach status` shows what it does, `longreach stop` stops motion", file=sys.stderr)
        return 130
