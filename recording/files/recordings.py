"""Which logs of a folder are recordings: what was cut out of one, beside the page of a fault, is found by name and not listed again."""

from __future__ import annotations

import re
from pathlib import Path

_CUT_OUT = re.compile(r"-incident-\d+$")


def recordings(folder: Path) -> list[Path]:
    """By name."""
    return sorted(path for path in folder.glob("*.mcap") if not _CUT_OUT.search(path.stem))


def cut_out_of(log: Path, fault: int) -> Path:
    """Where the time before a fault stands as a log of its own."""
    return log.with_name(f"{log.stem}-incident-{fault}.mcap")
