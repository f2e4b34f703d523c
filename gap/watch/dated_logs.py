"""The logs of a folder in the order in which they were recorded, and those of which that cannot be told."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from mcap.reader import make_reader

from config.errors import LogError, LongreachError
from recording.files.reader import log_bytes
from recording.files.recover import was_closed
from recording.files.scan import BAD_INDEX

ENDINGS = (".mcap", ".csv", ".tsv", ".mat")
_STAMPED_NS = 10**18  # 2001: a log with stamps from zero was imported, and its own time is not known
_IN_NAME = re.compile(r"(20\d\d)-?([01]\d)-?([0-3]\d)(?:[T_ -]?([0-2]\d)[-:h]?([0-5]\d)(?:[-:]?([0-5]\d))?)?(?!\d)")


@dataclass(frozen=True, slots=True)
class DatedLog:
    path: Path
    begun: datetime


@dataclass(frozen=True, slots=True)
class Unusable:
    """A log that says nothing about the rig, why, and the command to type next."""

    path: Path
    why: str
    next_step: str

    @classmethod
    def of(cls, path: Path, error: LongreachError) -> Unusable:
        said = error.refusal
        value = f": {said.value} {said.unit}".rstrip() if said.value else ""
        limit = f" (limit: {said.limit} {said.unit}".rstrip() + ")" if said.limit else ""
        place = said.where.removeprefix(str(path)).removeprefix(": ")
        return cls(path, f"{place + ': ' if place else ''}{said.what}{value}{limit}", said.next_step)


def dated_logs(folder: Path, rig_name: str) -> tuple[list[DatedLog], list[Unusable]]:
    """Of one rig. LogError where the folder holds no log at all."""
    if folder.is_file():
        raise LogError("this is a file, not a folder of logs", where=str(folder), mend={"--logs": str(folder.parent)})
    if not folder.is_dir():
        raise LogError("no such folder of logs", where=str(folder), next_step="Name the folder that the daemon writes its logs to.")
    logs, refused = [], []
    for path in sorted(path for path in folder.iterdir() if path.suffix.lower() in ENDINGS and not path.name.startswith(".")):
        try:
            logs.append(DatedLog(path, _begun(path, rig_name)))
        except LogError as error:
            refused.append(Unusable.of(path, error))
    if not logs and not refused:
        advice = f"Logs end in {', '.join(ENDINGS)}."
        raise LogError("the folder holds no logs", where=str(folder), next_step=advice)
    return sorted(logs, key=lambda log: (log.begun, log.path)), refused


def _begun(path: Path, rig_name: str) -> datetime:
    stamp_ns = _stamp_ns(path, rig_name) if path.suffix.lower() == ".mcap" else 0
    if stamp_ns >= _STAMPED_NS:
        return datetime.fromtimestamp(stamp_ns * 1e-9, UTC)
    for numbers in _dates(path.stem):
        return numbers
    named = path.with_name(f"YYYY-MM-DDTHHMM-{path.name}")  # no example: who pastes it would give the log a false date
    advice = f"Put the date (UTC) into its name: mv {shlex.quote(str(path))} {shlex.quote(str(named))}"
    raise LogError("nothing says when it was recorded", where=str(path), next_step=advice)


def _stamp_ns(path: Path, rig_name: str) -> int:
    """Of the first message; 0 where the log says nothing."""
    log_bytes(path)  # LogError for an empty file and for what is no log: there is nothing to recover
    if not was_closed(path):
        raise LogError("it is still being recorded, or was cut", where=str(path), next_step=f"longreach log recover {path}")
    try:
        with path.open("rb") as file:
            reader = make_reader(file)
            summary = reader.get_summary()
            about = {entry.name: entry.metadata for entry in reader.iter_metadata()}.get("recording", {})
    except BAD_INDEX as error:
        raise LogError("its index cannot be read", where=str(path), next_step=f"longreach log recover {path}") from error
    if about.get("rig_name", rig_name) not in ("", rig_name):
        advice = f"longreach gap watch --rig with the file of {about['rig_name']}"
        raise LogError("it is of another rig", value=about["rig_name"], limit=rig_name, where=str(path), next_step=advice)
    return summary.statistics.message_start_time if summary and summary.statistics else 0


def _dates(stem: str) -> Iterator[datetime]:
    """Every date in a name, with the time of day where it is there too."""
    for found in _IN_NAME.finditer(stem):
        try:
            yield datetime(*(int(part) for part in found.groups(default="0")), tzinfo=UTC)  # type: ignore[misc,arg-type]
        except ValueError:
            continue
