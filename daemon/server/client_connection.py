"""The client whose request is being answered. Motion that has to wait must not begin once that client, who could stop it, has left."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

_is_gone: ContextVar[Callable[[], bool]] = ContextVar("_is_gone", default=lambda: False)


def answer_for_client(is_gone: Callable[[], bool]) -> None:
    """Everything that this asyncio task answers from now on comes from one client; `is_gone` says whether it has hung up."""
    _is_gone.set(is_gone)


def client() -> Callable[[], bool]:
    """Who asked: the same object in everything that one client asks; calling it tells whether that client has hung up."""
    return _is_gone.get()


def client_has_left() -> bool:
    """Whether the client that asked has closed its connection. False where there is none (a call within the process)."""
    return _is_gone.get()()
