"""Between the facts and the controller: picks its inputs out of the cycle's facts and puts what it computes back."""

from __future__ import annotations

from math import nan
from typing import Any

from config.schema.rig import Rig
from daemon.checks.declared.driving_by_hand import FACTS
from daemon.cycle.facts import Facts
from recording.format.fields import TIP_CORRECTION, field_of_signal
from servo_control.controller import Controller
from servo_control.servo.oil_compensation import temperature_signals
from servo_control.signals import Inputs, Mode, Outputs, SetPoint
from servo_control.streaming.any_plan import AnyPlan


class ControllerPort:
    """`volts`: the commands of the last step, in the order of the rig's joints."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        self._controller = Controller(rig)
        at = facts.index
        self._cycle, self._mode, self._run, self._segment = map(at, ("cycle", "mode", "maneuver", "segment"))
        self.positions = tuple(at(f"{joint}.position") for joint in rig.joints)
        self._deflection, self._acceleration = at("tip.deflection_m"), at("tip.acceleration_mps2")
        self._correction = at(TIP_CORRECTION)
        self._oil = tuple(at(field_of_signal(name)) if name else -1 for name in temperature_signals(rig))
        self._oil_used = max(self._oil) >= 0
        names = ("target", "target_rate", "reference", "reference_rate", "velocity", "command_V", "following_error")
        self._joints = tuple(tuple(at(f"{joint}.{name}") for name in names) for joint in rig.joints)
        self._driving = tuple(map(at, FACTS))
        self.volts = [0.0] * len(rig.joints)

    def step(self, values: list[float], mode: Mode, run: int, point: SetPoint | None = None) -> Outputs:
        """One cycle of the controller; `run`: number of the run that was prepared, 0 for none; `point`: a set point that came for it."""
        position = tuple([values[index] for index in self.positions])
        deflection, acceleration = values[self._deflection], values[self._acceleration]
        oil = tuple([values[index] if index >= 0 else nan for index in self._oil]) if self._oil_used else ()
        outputs = self._controller.step(Inputs(int(values[self._cycle]), int(mode), run, position, deflection, acceleration, oil, point))
        values[self._mode], values[self._run], values[self._segment] = int(mode), run, outputs.segment
        values[self._correction] = outputs.tip_correction_rad
        for index, fact in zip(self._driving, outputs.driving, strict=True):
            values[index] = fact
        for number, joint in enumerate(outputs.joints):
            target, target_rate, reference, reference_rate, velocity, command, following = self._joints[number]
            values[target], values[target_rate] = joint.target, joint.target_rate
            values[reference], values[reference_rate] = joint.reference, joint.reference_rate
            values[velocity], values[command] = joint.velocity, joint.command_V
            values[following] = abs(joint.reference - position[number])
            self.volts[number] = joint.command_V
        return outputs

    def prepare(self, plan: AnyPlan) -> None:
        self._controller.prepare(plan)

    def snapshot(self) -> dict[str, Any]:
        return self._controller.snapshot()
