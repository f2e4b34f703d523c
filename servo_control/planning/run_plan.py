"""A run that was checked and can start: program, shaper, and what the operator wants to know beforehand."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from servo_control.path.program import Program, Segment
from servo_control.planning.run_request import RunRequest
from servo_control.shapers.shaper_setup import ShaperSetup


@dataclass(frozen=True, slots=True)
class Peaks:
    """What a run asks of one joint at most (rad or m, per s, per s²); rates and accelerations before shaping."""

    lowest: float
    highest: float
    rate: float
    acceleration: float


@dataclass(frozen=True, slots=True)
class TipMotion:
    """Peaks of the maneuver as it is written, and as it is run: ramps without corners and corrections need more speed in the same time.
    `limit_mps2`: of the acceleration across the link, None where the rig file has none. `joint` comes nearest to its own rate limit."""

    planned_speed_mps: float
    speed_mps: float
    planned_acceleration_mps2: float
    acceleration_mps2: float
    limit_mps2: float | None
    joint: str
    rate_share: float

    def text(self) -> str:
        """One line for the operator."""
        limit = "no limit in the rig file" if self.limit_mps2 is None else f"limit {self.limit_mps2:.4g} m/s^2"
        return (
            f"the tip reaches {self.speed_mps:.3g} m/s ({self.planned_speed_mps:.3g} m/s planned{self._times()}); the tip's acceleration "
            f"across the link {self.acceleration_mps2:.3g} m/s^2 ({limit}); {self.joint} {100.0 * self.rate_share:.0f} % of its rate limit"
        )

    def _times(self) -> str:
        faster = self.speed_mps / self.planned_speed_mps if self.planned_speed_mps > 0.0 else 1.0
        return f", × {faster:.2f}" if faster > 1.005 else ""


@dataclass(frozen=True, slots=True)
class RunPlan:
    """Made by plan_run. `duration_s` ends when the program and the shaper are at rest; `tip` is None on an arm without one."""

    request: RunRequest
    program: Program
    shaper: ShaperSetup
    joints: tuple[str, ...]
    start_position: tuple[float, ...]
    motion_end_s: float
    flush_s: float
    peaks: tuple[Peaks, ...]
    tip: TipMotion | None = None

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
            "tip": asdict(self.tip) if self.tip is not None else None,
        }
