"""`longreach`: the operator's command line, and the console script. Loads nothing before a bare `estop` has left."""

from __future__ import annotations

import sys

TYPE_CHECKING = False  # typing takes milliseconds to load
if TYPE_CHECKING:
    from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    words = sys.argv[1:] if argv is None else argv
    try:
        return _run(words)
    except KeyboardInterrupt:  # while it still loads
        return 130


def _run(words: Sequence[str]) -> int:
    if "estop" in words:
        from daemon.cli.estop_at_once import estop_at_once

        if estop_at_once(words):
            return 0
    from daemon.cli.command_line import run

    return run(words)


if __name__ == "__main__":
    sys.exit(main())
