"""A refused command with what did not fit put right: the words to type next, and what to change in a maneuver file before.

Standard library alone: every command may be refused, and `estop` must not wait for another's libraries.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from config.errors import LongreachError, ManeuverError

_FILES = (".yaml", ".yml")


def mended_command(error: LongreachError, words: Sequence[str], arguments: argparse.Namespace) -> tuple[list[str], list[str]]:
    """The words after `longreach`, and lines "FILE:LINE: KEY: VALUE". Both empty where the refusal names nothing that can be changed."""
    typed, lines, changed = list(words), [], False
    for key, value in error.refusal.mend.items():
        if key.startswith("-"):
            typed, changed = _with_option(typed, key, value, arguments), True
        elif value is not None and (place := _place_of(typed, key)) is not None:
            typed[place], changed = _replaced(typed[place], key, value), True
        elif value is not None and isinstance(error, ManeuverError):
            file = _maneuver_file(arguments)
            if file is None:
                typed += ["--set", f"{_prefix(arguments)}{key}={value}"]
            else:
                lines.append(f"{_line_of(file, key)}: {key}: {value}")
            changed = True
    return (typed, lines) if changed else ([], [])


def _with_option(words: list[str], option: str, value: str | None, arguments: argparse.Namespace) -> list[str]:
    """With the option at this value, alone ("") or left out (None), wherever it stood."""
    stands_alone = isinstance(getattr(arguments, option.strip("-").replace("-", "_"), None), bool)
    kept: list[str] = []
    skip = False
    for word in words:
        if skip or word.startswith(f"{option}="):
            skip = False
        elif word == option:
            skip = not stands_alone
        else:
            kept.append(word)
    given = [] if value is None else [option, value] if value else [option]
    place = min((k for k, word in enumerate(words) if word.partition("=")[0] == option), default=len(kept))
    return [*kept[:place], *given, *kept[place:]]


def _place_of(words: Sequence[str], key: str) -> int | None:
    """Of the word that is the key, sets it ("y0=3 in", "maneuver.y0=3 in") or has it as its value; the last one counts."""
    pattern = re.compile(rf"(?:maneuver\.)?{re.escape(key)}(?:=.*)?|[^=]+={re.escape(key)}", re.DOTALL)
    return next((k for k in reversed(range(len(words))) if pattern.fullmatch(words[k])), None)


def _replaced(word: str, key: str, value: str) -> str:
    name, equals, given = word.partition("=")
    if word == key or not equals:
        return value
    return f"{name}={value}" if given == key or name.removeprefix("maneuver.") == key else word


def _maneuver_file(arguments: argparse.Namespace) -> Path | None:
    """The file of one's own that the command runs; None for a shipped maneuver."""
    named = getattr(arguments, "maneuver", None)
    names = named if isinstance(named, list) else [named]
    return next((Path(name) for name in names if name and Path(name).suffix in _FILES), None)


def _line_of(file: Path, key: str) -> str:
    with suppress(OSError, UnicodeDecodeError):
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            if re.match(rf"{re.escape(key)}\s*:", line):
                return f"{file}:{number}"
    return str(file)


def _prefix(arguments: argparse.Namespace) -> str:
    """`simulate --set` is for the rig file as well."""
    return "maneuver." if arguments.command == "simulate" else ""
