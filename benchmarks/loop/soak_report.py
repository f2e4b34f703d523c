"""The page of a soak: cycles that are in the log, lateness beside an idle loop's, phases, and growth of memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from recording.files.reader import read_log

PHASES_US = {"read_us": " (with the simulated rig's step)", "compute_us": " (wanted: 60, 120)", "write_us": ""}


@dataclass
class Idle:
    """What the idle bursts have seen."""

    cycles: int = 0
    overruns: int = 0
    missed: int = 0
    late_p50_us: list[float] = field(default_factory=list)
    late_p99_us: list[float] = field(default_factory=list)
    late_max_us: float = 0.0

    def add(self, burst: dict[str, Any]) -> None:
        self.cycles += burst["cycles"]
        self.overruns += burst["overruns"]
        self.missed += burst["missed"]
        self.late_p50_us.append(burst["late_p50_us"])
        self.late_p99_us.append(burst["late_p99_us"])
        self.late_max_us = max(self.late_max_us, burst["late_max_us"])


@dataclass
class SoakSeen:
    """Everything the soak has seen: logs, idle bursts, faults, memory of every process in bytes, allocated blocks of the loop's, and p50
    and p99 of the time of handing a record over."""

    logs: list[Path] = field(default_factory=list)
    idle: Idle = field(default_factory=Idle)
    memory: dict[str, list[int]] = field(default_factory=dict)
    blocks: list[int] = field(default_factory=list)
    handed_over_us: list[tuple[float, float]] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def take_counts(self, path: Path) -> None:
        """What the loop's process answered, a line a count: blocks, p50 and p99 of handing a record over."""
        for line in path.read_text().splitlines():
            blocks, p50, p99 = map(float, line.split())
            self.blocks.append(int(blocks))
            self.handed_over_us.append((p50, p99))


def report(seen: SoakSeen) -> int:
    """Printed; exit status 1 when cycles are missing or were dropped."""
    parts = [_of_log(path) for path in seen.logs]
    cycles, absent, drops = (sum(getattr(part, name) for part in parts) for name in ("cycles", "absent", "drops"))
    seconds = sum(part.seconds for part in parts)
    print(f"{len(parts)} recordings, {cycles} cycles in them, absent {absent}, dropped {drops}, over {seconds:.1f} s")
    took_us = {name: np.concatenate([part.took_us[name] for part in parts]) for name in ("late_us", *PHASES_US)}
    _beside_idle(parts, took_us["late_us"], cycles, seen.idle)
    for name, wanted in PHASES_US.items():
        print(f"{name + ' p50, p99' + wanted:44}{np.percentile(took_us[name], 50):8.1f}{np.percentile(took_us[name], 99):8.1f}")
    for number, part in enumerate(parts, 1):
        closing = part.closing
        if not closing:
            print(f"recording {number}: not closed")
            continue
        work = ", ".join(f"{key} {closing[f'work_us_{key}']}" for key in ("p50", "p99", "max"))
        print(f"recording {number}: culprits {closing['overrun_culprits']}; grade {closing['grade']}; work per cycle, us: {work}")
    size = sum(path.stat().st_size for path in seen.logs) / 1e6
    print(f"log: {size:.1f} MB, {size / seconds:.4f} MB/s")
    for name, sizes in seen.memory.items():
        print(f"memory of {name}: {sizes[0] / 1e6:.1f} MB, grew by {(sizes[-1] - sizes[0]) / 1e6:+.2f} MB")
    print(blocks_line(seen.blocks))
    p50, p99 = (median(counts) for counts in zip(*seen.handed_over_us or [(nan, nan)], strict=True))
    print(f"a record packed and handed over: {p50:.1f} us at the median, {p99:.1f} at the p99 (wanted: 5)")
    for fault in seen.faults:
        print(f"fault: {fault}")
    return 1 if absent or drops else 0


def blocks_line(blocks: Sequence[int]) -> str:
    """Growth from the first quarter of the counts to the last one: single counts fall on different work."""
    if len(blocks) < 4:
        return f"allocated blocks of the loop's process: {len(blocks)} counts are too few"
    quarter = len(blocks) // 4
    first, last = median(blocks[:quarter]), median(blocks[-quarter:])
    return (
        f"allocated blocks of the loop's process: {len(blocks)} counts from {min(blocks)} to {max(blocks)}; "
        f"median of the first quarter {first:.0f}, of the last {last:.0f}: grew by {last - first:+.0f}"
    )


@dataclass(frozen=True, slots=True)
class Recorded:
    """What the report needs of one recording; the rest of it does not fit into memory for long."""

    cycles: int
    absent: int
    seconds: float
    took_us: dict[str, Any]
    closing: dict[str, str]

    @property
    def drops(self) -> int:
        return int(self.closing.get("drops", 0))


def _of_log(path: Path) -> Recorded:
    log = read_log(path)
    absent = int(np.sum(np.diff(log.columns["cycle"].astype(np.int64)) - 1))
    took_us = {name: log.columns[name].copy() for name in ("late_us", *PHASES_US)}
    return Recorded(log.cycles, absent, log.duration_s, took_us, log.metadata.get("closing", {}))


def _beside_idle(parts: Sequence[Recorded], late_us: Any, cycles: int, idle: Idle) -> None:
    """The table of what was late, the daemon beside the loop without work."""
    overruns, missed = (sum(int(part.closing.get(key, 0)) for part in parts) for key in ("overruns", "missed_periods"))
    per = 1e5 / max(1, cycles), 1e5 / max(1, idle.cycles)
    print(f"{'':28}{'daemon':>12}{'idle loop':>12}")
    print(f"{'cycles':28}{cycles:12}{idle.cycles:12}")
    print(f"{'overruns per 100 000':28}{overruns * per[0]:12.1f}{idle.overruns * per[1]:12.1f}")
    print(f"{'missed periods per 100 000':28}{missed * per[0]:12.1f}{idle.missed * per[1]:12.1f}")
    for percent, bursts in ((50, idle.late_p50_us), (99, idle.late_p99_us)):
        print(f"{f'late p{percent}, us (idle: median)':28}{np.percentile(late_us, percent):12.2f}{_median(bursts):12.2f}")
    print(f"{'latest, ms':28}{late_us.max() * 1e-3:12.2f}{idle.late_max_us * 1e-3:12.2f}")


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
