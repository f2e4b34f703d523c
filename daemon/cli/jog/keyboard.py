"""Keys of a terminal as they come: presses, repeats and, where the terminal tells them, releases. Standard library alone.

Most terminals send a key's characters again while it is held and say nothing when it is let go. Those with the kitty keyboard
protocol (kitty, foot, WezTerm, Ghostty, recent Konsole and iTerm2) say so when asked; it is asked for only where it is known.
"""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import tty
from types import TracebackType
from typing import Any, NamedTuple

from config.errors import DaemonError

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_SEQUENCE = re.compile(rb"\x1b[\[O]([0-9;:?<>]*)([A-Za-z~])")
_ASK = b"\x1b[?u\x1b[c"  # do you have the keyboard protocol? and a question that every terminal answers
_TELL_RELEASES, _AS_BEFORE = b"\x1b[>3u", b"\x1b[<u"
_RELEASED = "3"
ANSWER_S = 0.2


class Key(NamedTuple):
    """`name`: left, right, up, down, or the character."""

    name: str
    released: bool = False


def keys_in(data: bytes) -> tuple[list[Key], bytes]:
    """The keys in what a terminal sent, and the beginning of one whose end has not come yet."""
    keys, at = [], 0
    while at < len(data):
        if data[at] != 0x1B:
            keys.append(Key(chr(data[at])))
            at += 1
            continue
        found = _SEQUENCE.match(data, at)
        if found is None:
            if re.fullmatch(rb"\x1b[\[O]?[0-9;:?<>]*", data[at:]) and len(data) - at < 16:
                return keys, data[at:]
            at += 1
            continue
        at = found.end()
        key = _key(found[1].decode(), found[2].decode())
        if key is not None:
            keys.append(key)
    return keys, b""


def _key(parameters: str, final: str) -> Key | None:
    """Of an escape sequence: CSI 1 ; modifiers : event A for arrows, CSI code ; modifiers : event u for characters."""
    fields = parameters.split(";")
    released = len(fields) > 1 and fields[1].partition(":")[2] == _RELEASED
    if final in _ARROWS:
        return Key(_ARROWS[final], released)
    code = fields[0].partition(":")[0]
    if final == "u" and code.isdigit():
        control = len(fields) > 1 and fields[1].partition(":")[0] == "5"
        return Key("\x03" if control and code == "99" else chr(int(code)), released)
    return None


class Keyboard:
    """The terminal without echo and lines, for the length of a with statement. DaemonError where there is none."""

    def __init__(self) -> None:
        if not sys.stdin.isatty() or not sys.stdout.isatty():
            raise DaemonError(
                "driving by keys needs a terminal",
                value="no terminal",
                next_step="Type `longreach jog` in a terminal; programs use longreach.drive: docs/guide/operate/drive-by-hand.md.",
            )
        self._input, self._output = sys.stdin.fileno(), sys.stdout.fileno()
        self._before: list[Any] = termios.tcgetattr(self._input)
        self._rest = b""
        self.tells_releases = False

    def keys(self, wait_s: float) -> list[Key]:
        """What has come, waiting no longer than this for the first."""
        ready, _, _ = select.select([self._input], [], [], wait_s)
        if not ready:
            return []
        data = os.read(self._input, 1024)
        if not data:
            raise EOFError
        keys, self._rest = keys_in(self._rest + data)
        return keys

    def __enter__(self) -> Keyboard:
        tty.setcbreak(self._input)
        attributes = termios.tcgetattr(self._input)
        attributes[3] &= ~termios.ISIG  # Ctrl-C is a key here: it stops the arm first
        termios.tcsetattr(self._input, termios.TCSANOW, attributes)
        self.tells_releases = self._asked()
        if self.tells_releases:
            os.write(self._output, _TELL_RELEASES)
        return self

    def _asked(self) -> bool:
        """Whether the terminal knows the protocol; one that answers nothing does not."""
        os.write(self._output, _ASK)
        answer = b""
        while not re.search(rb"\x1b\[\?[0-9;]*c", answer) and select.select([self._input], [], [], ANSWER_S)[0]:
            answer += os.read(self._input, 1024)
        return re.search(rb"\x1b\[\?[0-9]+u", answer) is not None

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.tells_releases:
            os.write(self._output, _AS_BEFORE)
        termios.tcsetattr(self._input, termios.TCSAFLUSH, self._before)
