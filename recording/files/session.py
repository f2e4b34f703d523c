"""What every recording of one daemon has in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from recording.format.layout import CycleLayout, measured_twice

if TYPE_CHECKING:
    from config.loading.load import LoadedRig


@dataclass(frozen=True, slots=True)
class Session:
    """Plain data: the process that records never loads what reads a rig file.

    `motions`: "rotary" or "linear" by joint; `second`: joints with a second position sensor; `calibrations`: of every signal as used,
    engineering value = offset + scale × raw count; `facts` go into the metadata: clock, host, software.
    """

    rig_name: str
    rig_text: str
    rate_Hz: float
    motions: Mapping[str, str]
    second: frozenset[str]
    calibrations: Mapping[str, Any]
    log_dir: Path
    facts: Mapping[str, str]

    @classmethod
    def of(cls, loaded: LoadedRig, log_dir: Path, facts: Mapping[str, str]) -> Session:
        rig = loaded.rig
        motions = {name: joint.motion for name, joint in rig.joints.items()}
        calibrations = {name: signal.calibration.model_dump(mode="json") for name, signal in rig.signals.items()}
        return cls(rig.name, loaded.text, rig.loop.rate_Hz, motions, measured_twice(rig.signals), calibrations, log_dir, facts)

    def layout(self) -> CycleLayout:
        return CycleLayout(tuple(self.motions), list(self.motions.values()), self.second)
