"""Small logs for the tests of this folder, with known numbers in every field."""

from __future__ import annotations

import math
import random
from pathlib import Path

from recording.files.writer import LogWriter
from recording.format.layout import CycleLayout, Event

START_NS = 1_760_000_000_000_000_000
JOINTS = ("rotary", "prismatic")


def rows(layout: CycleLayout, count: int, seed: int = 1, rate_Hz: float = 1000.0) -> list[list[float]]:
    """Noisy sinusoids in every float field, counting cycles, rising time; optional pressures NaN (not fitted)."""
    noise = random.Random(seed)
    table = []
    for k in range(count):
        row = layout.blank()
        for number, field in enumerate(layout.fields):
            if field.ros_type == "float64" and "pressure_a" not in field.name and "pressure_b" not in field.name:
                row[number] = math.sin(k / rate_Hz * (1 + number % 7)) + noise.gauss(0, 0.01)
        row[layout.index("cycle")] = k
        row[layout.index("t_s")] = k / rate_Hz
        row[layout.index("mode")] = 2
        table.append(row)
    return table


def metadata(**more: str) -> dict[str, dict[str, str]]:
    return {"recording": {"recording_id": "r1", "rig_name": "bench", "rate_Hz": "1000", "software_version": "0.1.0", **more}}


def write(path: Path, count: int = 500, *, flush_every: int = 100, close: bool = True, **attachments: bytes) -> list[list[float]]:
    """A log of `count` cycles and one event every 100 cycles; returns the rows as written."""
    layout = CycleLayout(JOINTS)
    table = rows(layout, count)
    files = {name.replace("__", "."): ("application/octet-stream", data) for name, data in attachments.items()}
    writer = LogWriter(path, layout, files, metadata())
    for k, row in enumerate(table):
        t_ns = START_NS + k * 1_000_000
        if k % 100 == 50:
            writer.event(t_ns, Event(k, k * 1e-3, 20, "mode", f"mode changed at cycle {k}", {"mode": 2.0}))
        writer.cycle(t_ns, layout.pack(row))
        if k % flush_every == flush_every - 1:
            writer.flush()
    if close:
        writer.close({"grade": "A"})
    else:
        writer.flush()
        writer.abandon()
    return table


def same(left: float, right: float) -> bool:
    """Equal, with NaN equal to NaN."""
    return left == right or (math.isnan(left) and math.isnan(right))
