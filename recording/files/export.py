"""Writes the cycles of a log for other programs, by the file's ending: CSV, MATLAB (.mat) or Parquet. Every number keeps all its bits."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from config.errors import LogError, UsageError, WriteError
from config.parsing.nearest import nearest, nearest_text
from config.whole_file import whole_file
from recording.files.reader import Column, Log
from recording.files.recordings import asked

Columns = Mapping[str, Column]
MATLAB_NAME = 63  # characters: its namelengthmax


def export(log: Log, out: str | Path, columns: Sequence[str] | None = None) -> int:
    """Write `columns` (all by default; `t_s` always and first) and return the number of rows.

    Raises UsageError for a column the log does not have or an ending it does not know, WriteError for a file that cannot be written.
    """
    names = ["t_s", *(name for name in columns or log.columns if name != "t_s")]
    if wrong := [name for name in names if name not in log.columns]:
        advice = f"The log has: {', '.join(log.columns)}; {asked('info', log.path)} shows which hold numbers."
        what = "; ".join(f"the log has no column {name!r}{nearest_text(name, log.columns)}" for name in wrong)
        meant = {name: better for name in wrong if (better := nearest(name, log.columns))}
        raise UsageError(what, where=str(log.path), next_step=advice, mend=meant if len(meant) == len(wrong) else {})
    out = Path(out)
    if out.suffix.lower() not in WRITERS:
        better, known = str(out.with_suffix(".csv")), ", ".join(WRITERS)
        raise UsageError("this kind of file is not known", value=out.suffix, limit=known, where=str(out), mend={"-o": better})
    _write(out, {name: log.columns[name] for name in names}, WRITERS[out.suffix.lower()])
    return log.cycles


def _write(out: Path, columns: Columns, writer: Callable[[Path, Columns], None]) -> None:
    """Under a temporary name first."""
    with whole_file(out, "table") as temporary:
        writer(temporary, columns)


def _csv(path: Path, columns: Columns) -> None:
    """NaN is written as nan."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))


def _mat(path: Path, columns: Columns) -> None:
    """A column vector each; MATLAB knows no dots in names, so `rotary.position` is `rotary_position`."""
    from scipy.io import savemat  # slow to import, and only needed here

    names = {name: re.sub(r"\W", "_", name) for name in columns}
    _refuse_matlab_names(names)
    named = {names[name]: values for name, values in columns.items()}
    with path.open("wb") as file:
        savemat(file, named, oned_as="column", do_compression=True, long_field_names=True)


def _refuse_matlab_names(names: Mapping[str, str]) -> None:
    """scipy writes a second variable of one name, and MATLAB cuts a longer one: either way a signal would be lost without a word."""
    alike = Counter(names.values())
    advice = "Choose other columns with --columns, or export .csv or .parquet."
    same = [name for name, written in names.items() if alike[written] > 1]
    if same:
        raise LogError("columns would have one name in MATLAB", value=", ".join(same), next_step=advice)
    long = [name for name in names if len(name) > MATLAB_NAME]
    if long:
        limit = f"{MATLAB_NAME} characters"
        raise LogError("names are too long for MATLAB", value=", ".join(long), limit=limit, next_step=advice)


def _parquet(path: Path, columns: Columns) -> None:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        advice = "Install it: `pip install 'longreach[parquet]'`; or export .csv or .mat."
        raise WriteError("Parquet needs the library pyarrow", next_step=advice) from error
    parquet.write_table(pyarrow.table(dict(columns)), path)


WRITERS: Mapping[str, Callable[[Path, Columns], None]] = {".csv": _csv, ".mat": _mat, ".parquet": _parquet}
