"""Progress lines of long commands."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable


def teller(quiet: bool) -> Callable[[str], None]:
    """Progress lines with the time so far, on stderr."""
    start = time.monotonic()

    def tell(line: str) -> None:
        if not quiet:
            print(f"{time.monotonic() - start:6.1f} s  {line}", file=sys.stderr, flush=True)

    return tell
