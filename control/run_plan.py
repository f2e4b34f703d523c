"""A run that was checked and can start: program, shaper, and what the operator wants to know beforehand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from control.program import Program, Segment
from control.run_request import RunRequest
from control.shaper_setup import ShaperSetup


@dataclass(frozen=True, slots=True)
class Peaks:
    """What a run asks of one joint at most (rad or m, per s, per s²); rates and accelerations before shaping."""

    lowest: float
    highest: float
    rate: float
    acceleration: float


@dataclass(frozen=True, slots=True)
class RunPlan:
    """Made by plan_run. `duration_s` ends when the program and the shaper are at rest."""

    request: RunRequest
    program: Program
    shaper: ShaperSetup
    joints: tuple[str, ...]
    start_position: tuple[float, ...]
    motion_end_s: float
    flush_s: float
    peaks: tuple[Peaks, ...]

    @property
    def run(self) -> int:
        return self.request.run

    @property
    def duration_s(self) -> float:
        """Path time of the program, or its last motion and the shaper's flush if that ends later."""
        return max(self.program.duration_s, self.motion_end_s + self.flush_s)

    @property
    def segments(self) -> tuple[Segment, ...]:
        return self.program.segments()

    def summary(self) -> dict[str, Any]:
        """JSON-able facts for the operator."""
        return {
            "run": self.run,
            "maneuver": self.request.maneuver["name"],
            "kind": self.request.maneuver["kind"],
            "duration_s": self.duration_s,
            "motion_end_s": self.motion_end_s,
            "start_position": dict(zip(self.joints, self.start_position, strict=True)),
            "segments": [[s.name, s.kind, s.start_s, s.end_s] for s in self.segments],
            "shaper": self.shaper.kind,
            "shaped_joints": [self.joints[j] for j in self.shaper.joints],
            "focal_Hz": self.shaper.focal_Hz,
            "flush_s": self.flush_s,
            "peaks": {
                name: {"lowest": p.lowest, "highest": p.highest, "rate": p.rate, "acceleration": p.acceleration}
                for name, p in zip(self.joints, self.peaks, strict=True)
            },
        }
