"""asyncio for programs that Ctrl-C ends."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from typing import Any, TypeVar

Result = TypeVar("Result")


def until_ctrl_c(main: Coroutine[Any, Any, Result]) -> Result:
    """What `main` returns; KeyboardInterrupt for Ctrl-C at any time.

    Python up to 3.13 begins to count interruptions just after it begins to catch them (asyncio/runners.py), so one between the two is
    told as a cancellation. Nobody else cancels `main`.
    """
    try:
        return asyncio.run(main)
    except asyncio.CancelledError as error:
        raise KeyboardInterrupt from error
