"""Progress lines of long commands, with the time so far, on stderr."""

from __future__ import annotations

import sys
import time

from config.progress import Progress


def progress_lines(quiet: bool) -> Progress:
    """Progress lines with the time so far, on stderr."""
    start = time.monotonic()

    def progress(line: str) -> None:
        if not quiet:
            print(f"{time.monotonic() - start:6.1f} s  {line}", file=sys.stderr, flush=True)

    return progress
