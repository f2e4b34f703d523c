"""The client whose request is being answered: what has to wait must not begin when nobody is there any more who could stop it."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

_is_gone: ContextVar[Callable[[], bool]] = ContextVar("_is_gone", default=lambda: False)


def connected_while_not(is_gone: Callable[[], bool]) -> None:
    """Everything that this asyncio task answers from now on comes from one client; `is_gone` says whether it has hung up."""
    _is_gone.set(is_gone)


def hung_up() -> bool:
    """Whether the client that asked has closed its connection. False where there is none (a call within the process)."""
    return _is_gone.get()()
