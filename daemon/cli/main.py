"""`longreach`: the operator's command line. Each command group registers itself; this file only joins them and turns errors into exits.

Exit statuses: 0 done, 1 refused (with the reason), 2 wrong usage, 3 unusable data, 130 interrupted.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence

from config.errors import EXIT_REFUSED, LongreachError
from daemon.cli import (
    arm_commands,
    check_command,
    demo,
    design_command,
    faults_command,
    gap_command,
    identify_command,
    log_commands,
    motion_commands,
    paper_command,
    prove_command,
    replay_command,
    shape_command,
    status_commands,
    twin_command,
    warm_up_command,
)

Command = Callable[[argparse.Namespace], int]


def build_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="longreach",
        description="Controller for hydraulic long-reach arms: check a rig, run maneuvers, look at logs.",
        epilog="Commands that talk to the daemon find it through --socket, $LONGREACH_SOCKET or the usual place. See docs/.",
    )
    parser.add_argument("--socket", help="the daemon's Unix socket")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for group in (
        demo,
        check_command,
        status_commands,
        arm_commands,
        prove_command,
        motion_commands,
        log_commands,
        replay_command,
        design_command,
        paper_command,
        gap_command,
        identify_command,
        shape_command,
        warm_up_command,
        twin_command,
        faults_command,
    ):
        group.register(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status (and is the console script)."""
    arguments = build_parser().parse_args(argv)
    command: Command = arguments.run_command
    try:
        return command(arguments)
    except LongreachError as error:
        report(error, as_json=getattr(arguments, "json", False))
        return error.exit_status
    except KeyboardInterrupt:
        print("interrupted; the daemon goes on: `longreach status` shows what it does, `longreach stop` stops motion", file=sys.stderr)
        return 130
    except BrokenPipeError:
        return EXIT_REFUSED


def report(error: LongreachError, *, as_json: bool) -> None:
    """Print a refusal where its reader looks for it: JSON on stdout for scripts, text on stderr for people."""
    if as_json:
        print(json.dumps({"error": {"class": type(error).__name__, "text": str(error), **error.refusal.as_dict()}}))
    else:
        print(f"longreach: {error}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
