"""A command in a terminal emulator (pyte): what is on its screen, and keys pressed in it."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import struct
import subprocess
import sys
import termios
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pyte

from tests.support.daemon.running_daemon import until


class Terminal:
    """`lines`: what it shows. `seen`: every byte that the command wrote."""

    def __init__(self, command: list[str], columns: int, rows: int) -> None:
        self._screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self._screen)
        self.seen = b""
        self._end, other = pty.openpty()
        fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.settings_before = termios.tcgetattr(other)
        self._other = other
        environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": str(columns), "LINES": str(rows)}
        self.process = subprocess.Popen(
            command,
            stdin=other,
            stdout=other,
            stderr=other,
            env=environment,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),  # Ctrl-C becomes a signal
        )

    def lines(self) -> list[str]:
        while select.select([self._end], [], [], 0.0)[0]:
            data = os.read(self._end, 65536)
            self.seen += data
            self._stream.feed(data)
        return [line.rstrip() for line in self._screen.display]

    def shows(self, condition: Callable[[str], object], limit_s: float = 60.0) -> str:
        """The whole screen once it meets the condition."""
        try:
            until(lambda: condition("\n".join(self.lines())), limit_s)
        except AssertionError as error:
            raise AssertionError("\n".join(self.lines())) from error
        return "\n".join(self.lines())

    def press(self, key: bytes) -> None:
        os.write(self._end, key)

    def settings(self) -> object:
        return termios.tcgetattr(self._other)

    def close(self) -> None:
        self.process.kill()
        self.process.wait(10)
        os.close(self._end)
        os.close(self._other)


@contextmanager
def longreach_in_terminal(*words: str, columns: int = 100, rows: int = 30) -> Iterator[Terminal]:
    terminal = Terminal([sys.executable, "-m", "daemon.cli.main", *words], columns, rows)
    try:
        yield terminal
    finally:
        terminal.close()
