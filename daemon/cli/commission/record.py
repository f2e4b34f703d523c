"""What each step of a commissioning left: date, values, passed or not. Kept in one file, written anew by rename after every step."""

from __future__ import annotations

import dataclasses
import json
from dataclasses import dataclass, field
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

from config.errors import LogError
from config.whole_file import write_whole

FILE = "commissioning.json"


@dataclass(frozen=True, slots=True)
class Value:
    """A number or word that a step found, as the user reads it; `limit`: what it had to be, empty where nothing is asked of it."""

    what: str
    value: str
    limit: str = ""
    ok: bool = True


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a step says. `passed` None: not for this rig, with the reason in `text`."""

    passed: bool | None
    text: str
    values: list[Value] = field(default_factory=list)
    logs: list[str] = field(default_factory=list)
    files: list[str] = field(default_factory=list)

    @property
    def word(self) -> str:
        return {True: "passed", False: "NOT passed", None: "not for this rig"}[self.passed]


@dataclass(frozen=True, slots=True)
class StepRecord:
    """`rig_sha256`: of the rig file the step was made with; `on`: rig or simulated."""

    step: str
    date_utc: str
    by: str
    on: str
    rig_sha256: str
    outcome: Outcome

    def counts_for(self, sha: str, on: str) -> bool:
        """Whether the step need not be made again."""
        return self.rig_sha256 == sha and self.on == on and self.outcome.passed is not False


@dataclass(slots=True)
class Commissioning:
    """The records of one rig file, in `folder`."""

    folder: Path
    rig_name: str
    records: dict[str, StepRecord] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path, rig_name: str) -> Commissioning:
        """What was done so far; nothing yet where there is no file. LogError for a file that is none or of another rig."""
        path = folder / FILE
        if not path.exists():
            return cls(folder, rig_name)
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            records = {name: _record(entry) for name, entry in content["steps"].items()}
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            advice = "Move it away to begin anew."
            raise LogError("this is no record of a commissioning", value=str(error), where=str(path), next_step=advice) from error
        if content["rig"] != rig_name:
            advice = "Give another folder with --out."
            raise LogError("the record is of another rig", value=content["rig"], limit=rig_name, where=str(path), next_step=advice)
        return cls(folder, rig_name, records)

    def keep(self, record: StepRecord) -> None:
        """Add the record of a step and write the file."""
        self.records[record.step] = record
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(self.folder / FILE, json.dumps(self.as_dict(), indent=1) + "\n")

    def as_dict(self) -> dict[str, Any]:
        return {"rig": self.rig_name, "steps": {name: dataclasses.asdict(record) for name, record in self.records.items()}}


def record_of(step: str, outcome: Outcome, by: str, on: str, sha: str) -> StepRecord:
    return StepRecord(step, datetime.now(UTC).isoformat(timespec="seconds"), by, on, sha, outcome)


def hash_of(text: str) -> str:
    return sha256(text.encode()).hexdigest()


def _record(entry: dict[str, Any]) -> StepRecord:
    outcome = entry["outcome"]
    values = [Value(**value) for value in outcome["values"]]
    return StepRecord(**{**entry, "outcome": Outcome(**{**outcome, "values": values})})
