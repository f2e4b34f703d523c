"""Which logs of a folder are recordings: what was cut out of one, beside the page of a fault, is found by name and not listed again."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

from config.errors import LogError, UsageError
from config.whole_file import system_advice

_ENDING = ".mcap"
_CUT_OUT = re.compile(r"-incident-\d+$")


def logs_of(folder: Path) -> list[Path]:
    """Every log of a folder, by name. LogError for a folder that is not there or may not be looked into: it is not an empty one."""
    try:
        with os.scandir(folder) as entries:
            return sorted(folder / entry.name for entry in entries if entry.name.endswith(_ENDING))
    except OSError as error:
        reason, advice = error.strerror or str(error), system_advice(error)
        raise LogError("the folder of logs cannot be read", value=reason, where=str(folder), next_step=advice) from error


def recordings(folder: Path) -> list[Path]:
    """By name; as `logs_of`."""
    return [path for path in logs_of(folder) if not _CUT_OUT.search(path.stem)]


def log_name(chosen: Path) -> Path:
    """The name for a log to be written. UsageError for the ending of another kind of file: what opens that could not read it."""
    if chosen.suffix != _ENDING:
        mend = {"-o": f"{chosen.parent / (chosen.stem or 'log')}{_ENDING}"}
        raise UsageError("a log has another ending", value=chosen.suffix or chosen.name, limit=_ENDING, where="-o", mend=mend)
    return chosen


def asked(verb: str, log: Path) -> str:
    """The command that tells more of a log, as it is typed."""
    return f"`longreach log {verb} {shlex.quote(str(log))}`"


def cut_out_of(log: Path, fault: int) -> Path:
    """Where the time before a fault stands as a log of its own."""
    return log.with_name(f"{log.stem}-incident-{fault}.mcap")
