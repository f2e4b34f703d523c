"""Runs the command that was named and turns errors into exits; `commands` lists them all.

Exit statuses: 0 done, 1 refused (with the reason), 2 wrong usage, 3 unusable data, 128 and its number where a signal ended it (130:
interrupted).
"""

from __future__ import annotations

import argparse
import io
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType

from config.errors import EXIT_REFUSED, LongreachError
from config.whole_file import refused_by_system
from daemon.cli.commands import Parser, add_commands
from daemon.cli.connection import asks_daemon
from daemon.cli.refusal import close_output, report

TRACEBACK = "LONGREACH_TRACEBACK"  # in the environment: where an internal error came from
DAEMON_GOES_ON = "; the daemon goes on: `longreach status` shows what it does, `longreach stop` stops motion"
RunCommand = Callable[[argparse.Namespace], int]


class Ended(KeyboardInterrupt):
    """A signal that ends a program: whatever Ctrl-C does, an arm brought to rest and half a file taken away, is done then too."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


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
        with _ended_by_signals():
            status = command(arguments)
        print(end="", flush=True)  # a full disk is told like any other refusal
        return status
    except BrokenPipeError:
        return EXIT_REFUSED
    except KeyboardInterrupt as ended:
        with suppress(OSError):  # the terminal may be gone
            print(f"interrupted{_left_behind(arguments)}", file=sys.stderr)
        return 128 + (ended.number if isinstance(ended, Ended) else signal.SIGINT)
    except Exception as error:
        if TRACEBACK in os.environ:
            raise
        refusal = as_refusal(error)
        report(refusal, words, arguments)
        return refusal.exit_status
    finally:
        close_output()


def _left_behind(arguments: argparse.Namespace) -> str:
    """What is true of the rig after a command that had to do with a daemon; some clean up after themselves (`when_interrupted`)."""
    return getattr(arguments, "when_interrupted", DAEMON_GOES_ON) if asks_daemon(arguments) else ""


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """SIGTERM and the end of the terminal raise `Ended`, the first of them only: they come in pairs, and the second one must not cut short
    the way to rest. What `nohup` ignores stays ignored."""
    own = threading.current_thread() is threading.main_thread()
    numbers = [n for n in (signal.SIGTERM, signal.SIGHUP) if own and signal.getsignal(n) is signal.SIG_DFL]

    def end(number: int, _: FrameType | None) -> None:
        for each in numbers:
            signal.signal(each, signal.SIG_IGN)
        raise Ended(number)

    for number in numbers:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)


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
