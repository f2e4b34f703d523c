"""What a terminal can do that a file cannot: colours, and lines that replace each other. Standard library only."""

from __future__ import annotations

import os
import shutil
import sys
from types import TracebackType

_CODES = {"red": "1;31", "green": "32", "yellow": "33", "cyan": "36", "bold": "1"}


def coloured(text: str, colour: str) -> str:
    """`text` in a colour of _CODES, or bold, where stdout is a terminal and NO_COLOR is not set; else as it is."""
    if not colour or os.environ.get("NO_COLOR") or not sys.stdout.isatty():
        return text
    return f"\x1b[{_CODES[colour]}m{text}\x1b[0m"


def text_table(headings: list[str], rows: list[list[str]], left: tuple[int, ...] = (0,)) -> list[str]:
    """Lines of aligned columns; those in `left` begin at the left, numbers end at the right."""
    widths = [max(map(len, column)) for column in zip(headings, *rows, strict=True)]
    lines = []
    for row in [headings, *rows]:
        cells = [cell.ljust(width) if k in left else cell.rjust(width) for k, (cell, width) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(cells).rstrip())
    return [coloured(lines[0], "bold"), *lines[1:]]


class LiveScreen:
    """Lines that each update replaces. Use it in a with statement. Without a terminal only the last lines are printed, at the end."""

    def __init__(self) -> None:
        self._live = sys.stdout.isatty()
        self._shown = 0
        self._last: list[str] = []

    def update(self, lines: list[str]) -> None:
        self._last = lines
        if self._live:
            width, height = shutil.get_terminal_size()
            fitting = [_cut(line, width) for line in lines[: height - 1]]
            back = f"\x1b[{self._shown}F" if self._shown else ""
            sys.stdout.write(back + "".join(f"\x1b[2K{line}\n" for line in fitting) + "\x1b[J")
            sys.stdout.flush()
            self._shown = len(fitting)

    def __enter__(self) -> LiveScreen:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if not self._live and self._last:
            print("\n".join(self._last), flush=True)


def _cut(line: str, width: int) -> str:
    """A longer line would wrap and the next update miss its beginning; one with colours is short."""
    return line if "\x1b" in line else line[:width]
