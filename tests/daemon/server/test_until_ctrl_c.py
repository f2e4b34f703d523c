"""Ctrl-C at any time is Ctrl-C."""

from __future__ import annotations

import asyncio
import functools
import signal
from typing import Any

import pytest

from daemon.server.until_ctrl_c import until_ctrl_c


async def _goes_on() -> None:
    await asyncio.Event().wait()


async def _interrupted() -> None:
    signal.raise_signal(signal.SIGINT)
    await _goes_on()


def test_while_it_runs() -> None:
    with pytest.raises(KeyboardInterrupt):
        until_ctrl_c(_interrupted())


def test_as_soon_as_asyncio_catches_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the call that installs asyncio's own handler and whatever it does next: `longreach ui` ended in a traceback there."""
    install, sent = signal.signal, []

    def interrupted(number: int, handler: Any) -> Any:
        before = install(number, handler)
        if isinstance(handler, functools.partial) and not sent:
            sent.append(number)
            signal.raise_signal(number)
        return before

    monkeypatch.setattr(signal, "signal", interrupted)
    with pytest.raises(KeyboardInterrupt):
        until_ctrl_c(_goes_on())
    assert sent == [signal.SIGINT]


def test_what_it_returns() -> None:
    async def seven() -> int:
        return 7

    assert until_ctrl_c(seven()) == 7
