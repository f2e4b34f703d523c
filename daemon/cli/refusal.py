"""What a user reads when a command does not do what was asked: the refusal, and as the last line the next command to type."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from config.errors import DaemonError, DriverError, LogError, LongreachError

_TYPED = re.compile(r"`((?:longreachd?|systemctl|journalctl|df|ls) [^`]*)`")
_LINE_OF_A_FILE = re.compile(r"\.ya?ml:\d+")
_MEANT = re.compile(r"'([^']*)'[^:]*: nearest is '([^']*)'")


def program() -> str:
    """`longreach` as it has to be typed here: by its path when it is not on the search path."""
    called = Path(sys.argv[0])
    return str(called) if called.name == "longreach" and not shutil.which("longreach") else "longreach"


def report(error: LongreachError, command: str, words: Sequence[str], *, as_json: bool) -> None:
    """Print a refusal where its reader looks for it: JSON on stdout for scripts, text on stderr for people."""
    if as_json:
        print(json.dumps({"error": {"class": type(error).__name__, "text": str(error), **error.refusal.as_dict()}}))
        return
    print(f"longreach: {error}", file=sys.stderr)
    print(f"next: {next_command(error, command, words)}", file=sys.stderr)


def next_command(error: LongreachError, command: str, words: Sequence[str]) -> str:
    """What the refusal names; else, by its kind, the command that shows more. The same again only once the file it names is mended."""
    named = _TYPED.search(error.refusal.next_step)
    if named:
        typed = named[1]
    elif isinstance(error, (DaemonError, DriverError)):
        typed = "longreach why"
    elif isinstance(error, LogError) and error.refusal.where.endswith(".mcap"):
        typed = f"longreach log check {shlex.quote(error.refusal.where)}"
    elif _LINE_OF_A_FILE.search(str(error)):
        typed = shlex.join(["longreach", *words])
    elif (meant := _MEANT.search(error.refusal.what)) and meant[1] in words:
        typed = shlex.join(["longreach", *(meant[2] if word == meant[1] else word for word in words)])
    else:
        typed = f"longreach {command} --help"
    return re.sub(r"^longreach\b", program(), typed)
