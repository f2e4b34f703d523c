"""How long one Controller.step takes: the paper's line with two joints, for every shaper. Run: python -m benchmarks.loop.controller

Targets: 60 us on average with two joints and the adaptive shaper; wall time of this process on this machine, so compare only
figures of one machine. The worst cycle includes whatever else the machine did.
"""

from __future__ import annotations

import gc
import json
from dataclasses import asdict, dataclass
from math import nan
from time import perf_counter_ns

from config.loading.load import find, load_maneuver, load_rig
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Inputs, Mode

TARGET_US = 60.0
SHAPERS = ("none", "zvd", "robust_notch", "adaptive", "adaptive_coefficients", "adaptive_delay")


@dataclass(frozen=True, slots=True)
class StepTime:
    """Microseconds a step of a whole run, and of planning it (ms)."""

    shaper: str
    cycles: int
    mean_us: float
    p99_us: float
    worst_us: float
    plan_ms: float


def measure(rig: Rig, shaper: str) -> StepTime:
    """Run the line once with an arm that is always where it should be."""
    maneuver = maneuver_content(load_maneuver(find("maneuvers", "paper_line")).maneuver)
    choice = {"kind": shaper, "joints": ["rotary", "prismatic"]}
    before = perf_counter_ns()
    plan = plan_run(rig, RunRequest(1, maneuver, choice))
    plan_ms = (perf_counter_ns() - before) * 1e-6
    controller = Controller(rig)
    controller.prepare(plan)
    times = _run(controller, plan.start_position)
    times.sort()
    return StepTime(shaper, len(times), sum(times) / len(times), times[int(0.99 * len(times))], times[-1], plan_ms)


def _run(controller: Controller, position: tuple[float, ...]) -> list[float]:
    times: list[float] = []
    cycle, finished = 0, False
    gc.disable()
    try:
        while not finished:
            inputs = Inputs(cycle, Mode.HOLDING if cycle < 10 else Mode.RUNNING, 1, position, nan, nan)
            before = perf_counter_ns()
            out = controller.step(inputs)
            times.append((perf_counter_ns() - before) * 1e-3)
            position, finished = tuple([joint.reference for joint in out.joints]), out.finished
            cycle += 1
    finally:
        gc.enable()
    return times


def main() -> None:
    rig = load_rig(find("rigs", "ornl_testbed")).rig
    results = [measure(rig, shaper) for shaper in SHAPERS]
    print(json.dumps({"benchmark": "controller_step", "target_us": TARGET_US, "results": [asdict(r) for r in results]}, indent=1))


if __name__ == "__main__":
    main()
