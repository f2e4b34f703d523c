"""Driving a controller through modes with an ideal arm: each joint is an integrator, velocity = gain × command of the cycle before."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, nan

from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.planning.run_plan import RunPlan
from servo_control.signals import Inputs, Mode, Outputs

PERIOD_S = 0.001


class IdealArm:
    """Joint rates per volt are the inverse of the feed-forward, so the feed-forward alone tracks exactly."""

    def __init__(self, rig: Rig, position: list[float]) -> None:
        self.controller = Controller(rig)
        self.position = list(position)
        self.gains = [1.0 / servo.velocity_feedforward for servo in rig.servo.values()]
        self.cycle = 0
        self.log: list[Outputs] = []

    def step(self, mode: Mode, run: int = 0, spoil: Callable[[float], float] = lambda p: p) -> Outputs:
        positions = tuple(spoil(p) for p in self.position)
        out = self.controller.step(Inputs(self.cycle, mode, run, positions, nan, nan))
        for j, joint in enumerate(out.joints):
            assert isfinite(joint.command_V)
            self.position[j] += self.gains[j] * joint.command_V * PERIOD_S
        self.cycle += 1
        self.log.append(out)
        return out

    def hold(self, cycles: int = 5) -> Outputs:
        self.step(Mode.DISARMED)
        return [self.step(Mode.HOLDING) for _ in range(cycles)][-1]

    def start(self, plan: RunPlan, cycles: int) -> Outputs:
        """Arm, prepare and run for some cycles."""
        self.hold()
        self.controller.prepare(plan)
        return [self.step(Mode.RUNNING, plan.run) for _ in range(cycles)][-1]

    def until(self, mode: Mode, run: int, done: Callable[[Outputs], bool], most: int = 60_000) -> Outputs:
        for _ in range(most):
            out = self.step(mode, run)
            if done(out):
                return out
        raise AssertionError(f"not done after {most} cycles")

    def column(self, name: str, joint: int) -> list[float]:
        return [getattr(out.joints[joint], name) for out in self.log]
