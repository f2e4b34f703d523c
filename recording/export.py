"""Writes the cycles of a log as CSV with the names of the log; every number keeps all its bits."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence
from pathlib import Path

from config.errors import LogError
from config.nearest import nearest_text
from recording.reader import Log


def export_csv(log: Log, out: str | Path, columns: Sequence[str] | None = None) -> int:
    """Write `columns` (all by default; `t_s` always and first) and return the number of rows. NaN is written as nan.

    Raises LogError for a column the log does not have or a file that cannot be written.
    """
    names = ["t_s", *(name for name in columns or log.columns if name != "t_s")]
    for name in names:
        if name not in log.columns:
            advice = f"The log has: {', '.join(log.columns)}."
            raise LogError(f"the log has no column {name!r}{nearest_text(name, log.columns)}", where=str(log.path), next_step=advice)
    out = Path(out)
    temporary = out.with_name(f".{out.name}.{os.getpid()}.part")
    try:
        with temporary.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(names)
            writer.writerows(zip(*(log.columns[name].tolist() for name in names), strict=True))
        os.replace(temporary, out)
    except OSError as error:
        advice = "Free space or choose another directory."
        raise LogError("the table cannot be written", value=error.strerror or str(error), where=str(out), next_step=advice) from error
    finally:
        temporary.unlink(missing_ok=True)
    return log.cycles
