"""Runs the command that was named and turns errors into exits; `commands` lists them all.

Exit statuses: 0 done, 1 refused (with the reason), 2 wrong usage, 3 unusable data, 130 interrupted.
"""

from __future__ import annotations

import argparse
import io
import os
import sys
import traceback
from collections.abc import Callable, Sequence

from config.errors import EXIT_INTERRUPTED, EXIT_REFUSED, LongreachError
from config.whole_file import refused_by_system
from daemon.cli.commands import Parser, add_commands
from daemon.cli.connection import asks_daemon
from daemon.cli.refusal import close_output, report

TRACEBACK = "LONGREACH_TRACEBACK"  # in the environment: where an internal error came from
DAEMON_GOES_ON = "; the daemon goes on: `longreach status` shows what it does, `longreach stop` stops motion"
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
    arguments = argparse.Namespace()
    try:
        _write_to_any_terminal()
        build_parser().parse_args(words, arguments)
        command: RunCommand = arguments.run_command
        status = command(arguments)
        print(end="", flush=True)  # a full disk is told like any other refusal
        return status
    except BrokenPipeError:
        return EXIT_REFUSED
    except KeyboardInterrupt:
        print(f"interrupted{DAEMON_GOES_ON if asks_daemon(arguments) else ''}", file=sys.stderr)
        return EXIT_INTERRUPTED
    except Exception as error:
        if TRACEBACK in os.environ:
            raise
        refusal = as_refusal(error)
        report(refusal, words, arguments)
        return refusal.exit_status
    finally:
        close_output()


def as_refusal(error: Exception) -> LongreachError:
    """Also of what nobody foresaw, which has to be reported and not read."""
    if isinstance(error, LongreachError):
        return error
    if isinstance(error, OSError):
        return refused_by_system(error)
    at = traceback.extract_tb(error.__traceback__)[-1]
    advice = f"Please report this with what `longreach version` says and what the same command says with {TRACEBACK}=1 before it."
    said = f"{type(error).__name__}: {error}".rstrip(": ")
    return LongreachError("internal error of longreach", value=said, where=f"{at.filename}:{at.lineno}", next_step=advice)


def _write_to_any_terminal() -> None:
    """What its character set lacks (m/s² in ASCII) becomes a question mark."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
