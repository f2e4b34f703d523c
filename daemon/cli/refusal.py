"""What a user reads when a command does not do what was asked: the refusal, and as the last line the next command to type."""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from config.errors import ConfigError, DaemonError, DriverError, LogError, LongreachError
from daemon.cli.connection import asks_daemon
from daemon.cli.mended_command import mended_command

_LINE_OF_A_FILE = re.compile(r"\.ya?ml:\d+")
_MEANT = re.compile(r"(?:'(?P<word>[^']*)'|(?P<key>[\w.]+) is not a key)[^:]*: nearest is '(?P<better>[^']*)'")


def program() -> str:
    """`longreach` as it has to be typed here: by its path when it is not on the search path."""
    called = Path(sys.argv[0])
    return str(called) if called.name == "longreach" and not shutil.which("longreach") else "longreach"


def as_typed_here(command: str) -> str:
    """A command of `longreach` or `longreachd`, which lie side by side, with their path where the shell needs it."""
    return re.sub(r"^longreach(?=d?\b)", lambda name: program(), command)


def report(error: LongreachError, words: Sequence[str], arguments: argparse.Namespace) -> None:
    """Print a refusal where its reader looks for it: JSON on stdout for scripts, text on stderr for people."""
    if getattr(arguments, "json", False) and _printed(json.dumps(error_object(error))):
        return
    mended, lines = mended_command(error, words, arguments)
    typed = shlex.join(["longreach", *mended]) if mended else next_command(error, words, arguments)
    print(f"longreach: {error}", file=sys.stderr)
    print("".join(f"change {line}\n" for line in lines), end="", file=sys.stderr)
    print(f"next: {as_typed_here(typed)}", file=sys.stderr)


def error_object(error: LongreachError) -> dict[str, Any]:
    """A refusal for scripts; `problems` where a file has several."""
    problems = [each.as_dict() for each in error.problems] if isinstance(error, ConfigError) else []
    several = {"problems": problems} if len(problems) > 1 else {}
    return {"error": {"class": type(error).__name__, "text": str(error), **error.refusal.as_dict(), **several}}


def _printed(text: str, end: str = "\n") -> bool:
    """Whether standard output took it."""
    try:
        print(text, end=end, flush=True)
    except OSError:
        return False
    return True


def close_output() -> None:
    """What standard output did not take (a full disk, a reader that left) is given up: Python would print a traceback of it at the end."""
    if not _printed("", end=""):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def next_command(error: LongreachError, words: Sequence[str], arguments: argparse.Namespace) -> str:
    """What the refusal names; else, by its kind, the command that shows more. The same again only once the file it names is mended."""
    named = error.refusal.named_command()
    if named:
        return named
    if isinstance(error, (DaemonError, DriverError)) and asks_daemon(arguments):
        return "longreach why"
    if isinstance(error, LogError) and error.refusal.where and Path(error.refusal.where).is_dir():
        return f"longreach runs {shlex.quote(error.refusal.where)}"
    if isinstance(error, LogError) and error.refusal.where.endswith(".mcap"):
        return f"longreach log check {shlex.quote(error.refusal.where)}"
    if _LINE_OF_A_FILE.search(str(error)) or _names_own_file(error, words):
        return shlex.join(["longreach", *words])
    meant = _MEANT.search(error.refusal.what)
    better = [_as_meant(word, meant) for word in words] if meant else words
    if better != words:
        return shlex.join(["longreach", *better])
    return f"longreach {arguments.command} {getattr(arguments, 'verb', '')}".rstrip() + " --help"


def _as_meant(word: str, meant: re.Match[str]) -> str:
    """The word with the name that is nearest to the one there is not; that may be a key ("maneuver.speeed=3 in/s")."""
    key, equals, value = word.partition("=")
    if equals and key.removeprefix("maneuver.") == meant["key"]:
        return f"{key.removesuffix(meant['key'])}{meant['better']}={value}"
    return meant["better"] if word == meant["word"] else word


def _names_own_file(error: LongreachError, words: Sequence[str]) -> bool:
    """Whether the refusal says what is wrong in a file that the command names."""
    place = error.refusal.where
    return bool(error.refusal.next_step) and any(place == word or place.startswith(f"{word}:") for word in words if Path(word).is_file())
