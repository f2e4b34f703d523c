"""Weeks of logs of a simulated axis of which one thing changes, as MCAP recordings with stamps, or as tables with dates in their names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from config.loading.load import rig_from_text
from recording.files.writer import LogWriter
from recording.format.layout import CDR_HEADER, CycleLayout
from tests.support.gap import axis_logs

BEGUN = datetime(2026, 3, 2, 8, 0, tzinfo=UTC)
DURATION_S = 4.0


def moments(count: int, every_days: float = 2.0) -> list[datetime]:
    return [BEGUN + timedelta(days=every_days * k) for k in range(count)]


def write_tables(folder: Path, when: Sequence[datetime], truth: Callable[[int], str], seed: int = 0) -> list[Path]:
    """One CSV a moment; `truth`: rig text of the machine at each."""
    folder.mkdir(parents=True, exist_ok=True)
    return [
        axis_logs.write(folder / f"axis-{moment:%Y%m%d-%H%M%S}.csv", axis_logs.simulated(rig_from_text(truth(k)), seed + k, DURATION_S))
        for k, moment in enumerate(when)
    ]


def write_recording(path: Path, columns: axis_logs.Columns, begun: datetime, rig_name: str) -> Path:
    """As the recorder does: each cycle at its deadline on the wall clock."""
    layout = CycleLayout(("axis",), ["linear"], {})
    packed = np.zeros((len(columns["t_s"]), layout.struct.size), dtype=np.uint8)
    packed[:, : len(CDR_HEADER)] = np.frombuffer(CDR_HEADER, dtype=np.uint8)
    table = packed.view(layout.dtype)[:, 0]
    for field in layout.fields:
        table[field.name] = columns.get(field.name, np.nan if field.ros_type == "float64" else 0)
    first_ns = round(begun.timestamp() * 1e9)
    writer = LogWriter(path, layout, {}, {"recording": {"rig_name": rig_name}}, first_ns)
    for t_s, row in zip(columns["t_s"], packed, strict=True):
        writer.cycle(first_ns + round(1e9 * float(t_s)), row.tobytes())
    writer.close({})
    return path
