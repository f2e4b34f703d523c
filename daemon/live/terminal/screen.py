"""Keeps a glance on the terminal until q, Ctrl-C or the terminal's end; the terminal is then as it was before."""

from __future__ import annotations

import asyncio
import os
import sys
import termios
import time
import tty
from collections.abc import Awaitable, Iterator
from contextlib import contextmanager, suppress
from typing import TypeVar

from rich.console import Console
from rich.live import Live

from daemon.live.source.feed import Feed
from daemon.live.source.pending import Pending
from daemon.live.terminal.glance import Glance

T = TypeVar("T")

PICTURES_HZ = 8.0
_LEAVE = ("q", "Q", "\x03", "\x04", "")  # Ctrl-C, Ctrl-D, end of input


async def show_top(socket: str) -> bool:
    """Until the user leaves. Without a terminal: one picture as text, as soon as there is one. False: it shows that no daemon answers."""
    feed = Feed(socket)
    feeding = asyncio.create_task(feed.run())
    try:
        with feed.watched() as pending:
            return await (_watch(pending) if sys.stdout.isatty() else _print_once(pending))
    finally:
        feeding.cancel()
        with suppress(asyncio.CancelledError):
            await feeding


async def _watch(pending: Pending) -> bool:
    console, glance = Console(), Glance()
    with _keys() as left, Live(console=console, screen=True, auto_refresh=False) as live:
        while not left.is_set():
            begun = time.monotonic()
            content = await within(1.0, pending.take())
            if content:
                glance.take(content)
            live.update(glance.lines(console.size.height), refresh=True)
            await within(max(0.0, begun + 1.0 / PICTURES_HZ - time.monotonic()), left.wait())
    return True


async def within(seconds: float, something: Awaitable[T]) -> T | None:
    """What comes in time, or None. (wait_for of Python 3.11 swallows a Ctrl-C that comes together with it.)"""
    with suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            return await something
    return None


async def _print_once(pending: Pending) -> bool:
    glance, missing, lost = Glance(), {"samples", "status", "checks"}, False
    while missing and not lost:
        content = await pending.take()
        glance.take(content)
        missing, lost = missing - content.keys(), bool(content.get("lost"))
    Console().print(glance.lines(24))
    return not lost


@contextmanager
def _keys() -> Iterator[asyncio.Event]:
    """Keys come one by one and are not shown; the event is set by one that leaves."""
    left = asyncio.Event()
    if not sys.stdin.isatty():
        yield left
        return
    descriptor, loop = sys.stdin.fileno(), asyncio.get_running_loop()
    before = termios.tcgetattr(descriptor)

    def read() -> None:
        if os.read(descriptor, 1).decode(errors="replace") in _LEAVE:
            left.set()

    tty.setcbreak(descriptor)
    loop.add_reader(descriptor, read)
    try:
        yield left
    finally:
        loop.remove_reader(descriptor)
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)
