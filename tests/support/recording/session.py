"""Records what a daemon would: the real controller on a shipped rig, modes in their order, an arm that follows at once, a ringing tip.

The arm here is deliberately simple: joints integrate their command, and the tip acceleration is a decaying sine of known size after
every planned move, so that what is read out of the log can be compared with what was put in.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from config.loading.load import LoadedRig, load_maneuver, load_rig
from config.schema.maneuver import maneuver_content
from recording.files.foxglove import foxglove_layout
from recording.files.writer import LogWriter
from recording.format.fields import CONTROLLER_FIELDS
from recording.format.layout import CycleLayout
from servo_control.controller import Controller
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Inputs, Mode, Outputs

START_NS = 1_760_000_000_000_000_000
SPEED_PER_VOLT = {"rotary": 0.752, "prismatic": 0.04826, "axis": 0.03}  # rad/s or m/s


@dataclass
class Session:
    """One recording under way. `ring_mps2` gives the tip's amplitude 1.0 s after the end of each move, by plan segment index."""

    path: Path
    rig_name: str = "ornl_testbed"
    ring_mps2: dict[int, float] = field(default_factory=dict)
    loaded: LoadedRig = field(init=False)
    cycle: int = 0

    def __post_init__(self) -> None:
        self.loaded = load_rig(self.rig_name)
        self.rig = self.loaded.rig
        self.layout = CycleLayout.of_rig(self.rig)
        self.controller = Controller(self.rig)
        self.position = [0.5 * sum(joint.travel) for joint in self.rig.joints.values()]
        self.run = 0
        attachments = {
            "rig.yaml": ("application/yaml", self.loaded.text.encode()),
            "calibration.json": ("application/json", b"{}"),
            "foxglove_layout.json": ("application/json", foxglove_layout(self.layout)),
            "controller_state.json": ("application/json", json.dumps(self.controller.snapshot()).encode()),
        }
        about = {"recording_id": "s1", "rig_name": self.rig.name, "rate_Hz": "1000", "software_version": "0.1.0"}
        self.writer = LogWriter(self.path, self.layout, attachments, {"recording": about})

    def plan(self, maneuver: str, run: int, shaper: str = "none", *, approach: bool = False) -> RunPlan:
        content = maneuver_content(load_maneuver(maneuver).maneuver)
        return plan_run(self.rig, RunRequest(run, content, {"kind": shaper}, start_position=list(self.position), approach=approach))

    def start(self, plan: RunPlan) -> None:
        """What the daemon does when the operator starts a run: attachments first, then prepare."""
        t_ns = START_NS + self.cycle * 1_000_000
        self.writer.attach(t_ns, f"run-{plan.run}.json", "application/json", plan.request.as_json().encode())
        self.writer.attach(t_ns, f"maneuver-{plan.run}.yaml", "application/yaml", b"longreach: maneuver/1\n")
        self.controller.prepare(plan)
        self.run = plan.run

    def cycles(self, mode: Mode, count: int, *, lost: Iterable[int] = ()) -> None:
        """`count` cycles in one mode; in those of `lost` the first joint's position is missing."""
        for k in range(count):
            self.step(mode, lost=k in set(lost))

    def until(self, mode: Mode, done: Callable[[Outputs], bool], plan: RunPlan | None = None, limit: int = 60_000) -> int:
        for k in range(limit):
            if done(self.step(mode, plan=plan)):
                return k + 1
        raise AssertionError("the run did not end")

    def step(self, mode: Mode, *, lost: bool = False, plan: RunPlan | None = None) -> Outputs:
        position = tuple(math.nan if lost and j == 0 else value for j, value in enumerate(self.position))
        tip = self._tip(plan) if plan is not None else 0.0
        outputs = self.controller.step(Inputs(self.cycle, int(mode), self.run, position, math.nan, tip))
        self._record(mode, position, tip, outputs)
        for j, (name, joint) in enumerate(zip(self.rig.joints, outputs.joints, strict=True)):
            self.position[j] += SPEED_PER_VOLT[name] * joint.command_V * 1e-3
        self.cycle += 1
        self._running = self._running + 1 if mode == Mode.RUNNING else 0
        return outputs

    _running = 0

    def _tip(self, plan: RunPlan) -> float:
        """A decaying sine after each move, with its given amplitude 1.0 s after the move's end."""
        assert self.rig.link_mode is not None
        tau = self._running * 1e-3
        for index, segment in enumerate(plan.segments):
            if index in self.ring_mps2 and segment.end_s <= tau < plan.segments[index + 1].end_s:
                omega = LinkFrequency(self.rig.link_mode).omega_d(self.position[1])
                after = tau - segment.end_s - 1.0
                return self.ring_mps2[index] * math.exp(-self.rig.link_mode.damping_ratio * omega * after) * math.sin(omega * after + 0.7)
        return 0.0

    def _record(self, mode: Mode, position: tuple[float, ...], tip: float, outputs: Outputs) -> None:
        row = self.layout.blank()
        values = {"cycle": self.cycle, "t_s": self.cycle * 1e-3, "mode": int(mode), "maneuver": self.run, "segment": outputs.segment}
        values |= {"tip.acceleration_mps2": tip, "tip.correction_rad": outputs.tip_correction_rad, "late_us": 10.0 + self.cycle % 7}
        values |= {signal: 1.0e6 for signal in ("rotary.supply_pressure_Pa", "prismatic.supply_pressure_Pa") if self.layout.has(signal)}
        for name, measured, joint in zip(self.rig.joints, position, outputs.joints, strict=True):
            values[f"{name}.position"] = measured
            values |= {f"{name}.{output}": getattr(joint, output) for output in CONTROLLER_FIELDS}
        for name, value in values.items():
            row[self.layout.index(name)] = value
        self.writer.cycle(START_NS + self.cycle * 1_000_000, self.layout.pack(row))

    def close(self) -> Path:
        self.writer.close({"grade": "A"})
        return self.path


def recorded_run(path: Path, maneuver: str = "paper_line", shaper: str = "none", ring_mps2: dict[int, float] | None = None) -> Path:
    """Arm, run one maneuver to its end, hold."""
    session = Session(path, ring_mps2=ring_mps2 or {})
    session.position = [0.0, 40 * 0.0254]  # where paper_line starts
    plan = session.plan(maneuver, 1, shaper)
    session.cycles(Mode.DISARMED, 30)
    session.cycles(Mode.ARMING, 10)
    session.cycles(Mode.HOLDING, 50)
    session.start(plan)
    session.cycles(Mode.HOLDING, 20)
    session.until(Mode.RUNNING, lambda outputs: outputs.finished, plan)
    session.cycles(Mode.HOLDING, 50)
    return session.close()
