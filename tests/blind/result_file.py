"""The results of a study: one line of JSON a case in results.jsonl, sorted by name; beside it a file for each case that has just ended.

A case writes its own file, so a study can be interrupted at any time and continued later or on another machine; `gather` moves these
into the one file.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from config.whole_file import replaced_when_done

ALL = "results.jsonl"
ENDED = "results"  # folder of the cases that are not gathered yet


def results(study: Path) -> dict[str, dict[str, Any]]:
    """Every result so far by the name of its case; a file of its own is newer than the line."""
    lines = (study / ALL).read_text(encoding="utf-8").splitlines() if (study / ALL).exists() else []
    found = {result["name"]: result for result in map(json.loads, lines)}
    return dict(sorted({**found, **{path.stem: json.loads(path.read_text()) for path in _ended(study)}}.items()))


def gather(study: Path) -> None:
    """Take the files of single cases into the one file. Stopped half-way, nothing is lost and the next call goes on."""
    ended = _ended(study)
    if not ended:
        return
    with replaced_when_done(study / ALL) as part:
        part.write_text("".join(json.dumps(result, separators=(",", ":")) + "\n" for result in results(study).values()), encoding="utf-8")
    for path in ended:
        path.unlink()


def of_case(study: Path, name: str) -> Path:
    """Where a case writes its result."""
    return study / ENDED / f"{name}.json"


def _ended(study: Path) -> list[Path]:
    return sorted((study / ENDED).glob("case-*.json"))
