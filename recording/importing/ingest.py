"""Makes a log of a table that was measured elsewhere, so that plots, checks and the search for missing physics work on it.

Such a log is of the kind "imported": there was no longreach controller, so it cannot be re-executed.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import numpy as np
import numpy.typing as npt

from config.errors import LogError
from config.loading.import_map import LoadedMap, load_map
from config.loading.load import LoadedRig
from config.parsing.nearest import nearest_text
from config.whole_file import refuse_existing, replaced_when_done
from recording.files.writer import LogWriter
from recording.format.layout import CDR_HEADER, CycleLayout
from recording.importing.coarse_clock import spread
from recording.importing.parts import Span, parts, rows
from recording.importing.read_table import read_table
from recording.importing.source_columns import columns_by_map, columns_by_name, lacking
from recording.importing.table import Floats, SourceTable
from recording.importing.table_check import rate_Hz, usable, warnings_about
from servo_control.signals import Mode

_ROWS_AT_ONCE = 20_000  # packed, so that hours of data need no more memory than their columns


@dataclass(frozen=True, slots=True)
class IngestReport:
    """What was read and what was left out."""

    written: Path
    rows: int
    duration_s: float
    rate_Hz: float
    filled: tuple[str, ...]
    ignored: tuple[str, ...]
    unknown: tuple[str, ...]
    warnings: tuple[str, ...]

    def text(self) -> str:
        lines = [f"{self.written}: {self.rows} rows, {self.duration_s:.3f} s at {self.rate_Hz:.6g} Hz, columns {', '.join(self.filled)}."]
        if self.ignored:
            lines.append(f"Left out as the map says: {', '.join(self.ignored)}.")
        if self.unknown:
            lines.append(f"Left out because nothing says what they are: {', '.join(self.unknown)}.")
        return "\n".join([*lines, *self.warnings])


def ingest(csv_path: str | Path, map_path: str | Path | None, out_path: str | Path, rig: LoadedRig | None = None) -> IngestReport:
    """Write one log from a whole table, gaps and all; `ingest_parts` writes one on each side of a long gap."""
    (report,) = ingest_parts(csv_path, map_path, out_path, rig, cut=False)
    return report


def ingest_parts(
    csv_path: str | Path,
    map_path: str | Path | None,
    out_path: str | Path,
    rig: LoadedRig | None = None,
    spans: Sequence[Span] = (),
    *,
    cut: bool = True,
) -> list[IngestReport]:
    """Write a log of every span of a table (s of t_s; none: all of it), cut at long gaps: `out_path`, or NAME-1, NAME-2 … of several.

    Without a map the table's column names must be those of the log. `rig`, when given, goes into the log and its joints must be those of
    the table. Raises LogError (data), ConfigError (map) or UsageError (a log of that name).
    """
    source, out = Path(csv_path), Path(out_path)
    table = read_table(source)
    loaded = load_map(map_path) if map_path is not None else None
    layout, columns = columns_by_map(table, loaded) if loaded else columns_by_name(table, rig.rig if rig else None)
    table = _with_regular_time(table, columns)  # the whole table's period is most certain; a row lost elsewhere hides that of the spans
    table, columns = _asked_for(table, columns, spans)
    table = _with_regular_time(table, columns)
    columns, left_out = usable(table, columns, layout.joint_names)
    left_out = (*table.notes, *(lacking(table, loaded.map) if loaded else ()), *left_out)
    _refuse_other_joints(layout, rig)
    pieces, alone = parts(columns, spans, str(source)) if cut else ([columns], ())
    names = [out] if len(pieces) == 1 else [out.with_name(f"{out.stem}-{number}{out.suffix}") for number in range(1, len(pieces) + 1)]
    for name in names:
        refuse_existing(name, "log", "Choose another name; recordings are never written over.", out)
    for name, piece in zip(names, pieces, strict=True):
        _write(name, layout, piece, _about(source, piece["t_s"], loaded, rig), _attachments(loaded, rig))
    return [_report(name, table, layout, piece, loaded, (*left_out, *alone)) for name, piece in zip(names, pieces, strict=True)]


def _with_regular_time(table: SourceTable, columns: dict[str, Floats]) -> SourceTable:
    """Spreads stamps that a coarse clock has doubled, in `columns`; the table with a note about it."""
    if "t_s" not in columns:
        return table
    columns["t_s"], said = spread(columns)
    return replace(table, notes=(*table.notes, *said))


def _asked_for(table: SourceTable, columns: dict[str, Floats], spans: Sequence[Span]) -> tuple[SourceTable, dict[str, Floats]]:
    """Without the rows that no span has: what is wrong there does not count. Where nothing is left, all rows, for the message."""
    t = columns.get("t_s")
    if not spans or t is None:
        return table, columns
    inside = np.any([(t >= first) & (t <= last) for first, last in spans], axis=0)
    if not inside.any():
        return table, columns
    return replace(table, columns=rows(table.columns, inside), lines=table.lines[inside]), rows(columns, inside)


def _report(
    out: Path, table: SourceTable, layout: CycleLayout, columns: dict[str, Floats], loaded: LoadedMap | None, left_out: tuple[str, ...]
) -> IngestReport:
    known = [field.name for field in layout.fields]
    used = {entry.source for entry in loaded.map.columns.values()} if loaded else set(columns)
    ignored = tuple(name for name in table.columns if loaded and name in loaded.map.ignored)
    unknown = tuple(name + nearest_text(name, known) for name in table.columns if name not in used and name not in ignored)
    t = columns["t_s"]
    warnings = (*left_out, *warnings_about(columns))
    return IngestReport(out, len(t), float(t[-1] - t[0]), rate_Hz(t), tuple(columns), ignored, unknown, warnings)


def _refuse_other_joints(layout: CycleLayout, rig: LoadedRig | None) -> None:
    if rig is None or tuple(rig.rig.joints) == layout.joint_names:
        return
    advice = "Give the rig these data are from, or correct the map's joints."
    names = f"{', '.join(layout.joint_names)} instead of {', '.join(rig.rig.joints)}"
    raise LogError("the data have other joints than the rig", value=names, where=rig.path, next_step=advice)


def _about(source: Path, t: Floats, loaded: LoadedMap | None, rig: LoadedRig | None) -> dict[str, str]:
    rig_name = rig.rig.name if rig else loaded.map.rig if loaded else ""
    return {
        "kind": "imported",
        "source": source.name,
        "source_sha256": hashlib.sha256(source.read_bytes()).hexdigest(),
        "map": loaded.map.name if loaded else "",
        "rig_name": rig_name,
        "rate_Hz": repr(rate_Hz(t)),
        "software_version": version("longreach"),
    }


def _attachments(loaded: LoadedMap | None, rig: LoadedRig | None) -> dict[str, tuple[str, bytes]]:
    texts = {"rig.yaml": rig.text if rig else None, "map.yaml": loaded.text if loaded else None}
    return {name: ("application/yaml", text.encode()) for name, text in texts.items() if text is not None}


def _write(
    out: Path, layout: CycleLayout, columns: dict[str, Floats], about: dict[str, str], attachments: dict[str, tuple[str, bytes]]
) -> None:
    """Under a temporary name first: a refused import leaves nothing behind."""
    t = columns["t_s"]
    stamps_ns = np.round((t - t[0]) * 1e9).astype(np.int64)
    with replaced_when_done(out) as temporary:
        writer = LogWriter(temporary, layout, attachments, {"recording": about})
        for first in range(0, len(t), _ROWS_AT_ONCE):
            piece = slice(first, first + _ROWS_AT_ONCE)
            for t_ns, record in zip(stamps_ns[piece].tolist(), _records(layout, rows(columns, piece), first), strict=True):
                writer.cycle(t_ns, record.tobytes())
        writer.close({})


def _records(layout: CycleLayout, columns: dict[str, Floats], first: int) -> npt.NDArray[np.uint8]:
    """Rows packed, of which `first` is the first one's number. What the table does not say: cycles are counted, the mode is running,
    numbers are NaN."""
    count = len(columns["t_s"])
    packed = np.zeros((count, layout.struct.size), dtype=np.uint8)
    packed[:, : len(CDR_HEADER)] = np.frombuffer(CDR_HEADER, dtype=np.uint8)
    table = packed.view(layout.dtype)[:, 0]
    for field in layout.fields:
        table[field.name] = columns.get(field.name, np.nan if field.ros_type == "float64" else 0)
    table["cycle"] = np.arange(first, first + count)
    if "mode" not in columns:
        table["mode"] = Mode.RUNNING
    return packed
