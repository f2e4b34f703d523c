"""The controller: mode and measured positions in, commands out, once a cycle. No clock and no I/O, so a log re-executes bit for bit.

DISARMED, ARMING,
PROVING, FAULT            command 0; references follow the measured positions; a run under way is forgotten
HOLDING                   the reference of the moment of entry is held; a run that has not come to rest is stopped first
RUNNING                   the prepared run, if its number is `inputs.run`, from its beginning; a run never starts twice
STOPPING                  the run is slowed down along its path and the shaper flushed, then `stopped`
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.link.end_point import EndPointFeedback
from servo_control.numerics.limits import ReferenceLimit, clamp
from servo_control.planning.run_request import RunRequest
from servo_control.servo.link_notch import link_notch
from servo_control.servo.servo import JointServo
from servo_control.signals import NOT_DRIVEN, Inputs, JointOutput, Mode, Outputs
from servo_control.streaming.any_plan import AnyMotion, AnyPlan, begin, plan_any
from servo_control.streaming.stream_motion import StreamMotion

OFF = (int(Mode.DISARMED), int(Mode.ARMING), int(Mode.FAULT), int(Mode.PROVING))
SNAPSHOT_VERSION = 1


class Controller:
    """All joints of one rig. Everything is read from the rig file here and nowhere later."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._period_s = 1.0 / rig.loop.rate_Hz
        joints = list(rig.joints.values())
        self._rates = [joint.rate_limit for joint in joints]
        self._accelerations = [joint.acceleration_limit for joint in joints]
        notches = {"rotary": link_notch(rig)}
        self._servos = [JointServo(joint, rig.servo[name], self._period_s, notches.get(name)) for name, joint in rig.joints.items()]
        self._limits = [ReferenceLimit(joint.travel, joint.rate_limit, self._period_s) for joint in joints]
        link, feedback = rig.link_mode, rig.end_point
        self._end_point: EndPointFeedback | None = None
        names = list(rig.joints)
        self._has_link = "rotary" in names and "prismatic" in names
        self._rotary, self._prismatic = (names.index("rotary"), names.index("prismatic")) if self._has_link else (0, 0)
        if feedback is not None and link is not None:
            self._end_point = EndPointFeedback(feedback, link, joints[self._prismatic].travel, self._period_s)
        self._corrections = [0.0] * len(joints)  # added to the joints' errors by the end-point feedback
        self._pushes = [0.0] * len(joints)  # shares of their friction that it wants to have overcome
        self._reference_rate = [0.0] * len(joints)
        self._engaged = False
        self._target = [nan] * len(joints)
        self._reference = [nan] * len(joints)
        self._plan: AnyPlan | None = None
        self._motion: AnyMotion | None = None
        self._started_run = 0  # the last run that was started, 0 for none

    def prepare(self, plan: AnyPlan) -> None:
        """The run that may start next. Raises ManeuverError when it was planned for a rig with other joints."""
        if plan.joints != tuple(self._rig.joints):
            raise ManeuverError("the run was planned for other joints", value=", ".join(plan.joints), limit=", ".join(self._rig.joints))
        self._plan = plan

    def step(self, inputs: Inputs) -> Outputs:
        """One cycle. Positions that are not finite are taken as lost samples."""
        for servo, position in zip(self._servos, inputs.position, strict=True):
            servo.measure(position)
        for servo, temperature in zip(self._servos, inputs.oil_temperature_C, strict=False):  # empty on a rig without compensation
            servo.measure_oil(temperature)
        if self._has_link:
            self._servos[self._rotary].follow_extension(self._servos[self._prismatic].position)
        if inputs.mode in OFF:
            return self._off()
        if not self._engaged and not self._engage():
            return self._off()
        if self._end_point is not None:
            self._feed_back(self._end_point, inputs)
        if inputs.mode == Mode.RUNNING and self._may_start(inputs.run):
            self._start()
        return self._run(inputs, self._motion) if self._motion is not None else self._hold(inputs)

    def _feed_back(self, end_point: EndPointFeedback, inputs: Inputs) -> None:
        rotary, prismatic = self._servos[self._rotary], self._servos[self._prismatic]
        measured = (prismatic.position, prismatic.velocity, rotary.velocity)
        rates = self._reference_rate
        planned = (self._reference[self._prismatic], rates[self._prismatic], rates[self._rotary])
        tip = (inputs.tip_deflection_m, inputs.tip_acceleration_mps2)
        correction = end_point.step(tip, measured, planned)
        self._corrections[self._rotary], self._pushes[self._rotary] = correction, end_point.push(correction)

    @property
    def _tip_correction(self) -> float:
        return self._corrections[self._rotary] if self._end_point is not None else nan

    def _off(self) -> Outputs:
        if self._end_point is not None:
            self._end_point.release()
            self._corrections[self._rotary] = self._pushes[self._rotary] = 0.0
        self._engaged = False
        self._motion = None
        outputs = []
        for j, servo in enumerate(self._servos):
            servo.release()
            self._target[j] = self._reference[j] = servo.position
            self._reference_rate[j] = 0.0
            outputs.append(JointOutput(servo.position, 0.0, servo.position, 0.0, servo.velocity, 0.0))
        return Outputs(tuple(outputs), 0, False, False, self._tip_correction)

    def _engage(self) -> bool:
        """Hold where the arm is. Not before every joint has had a good sample since the start."""
        if not all(isfinite(servo.position) for servo in self._servos):
            return False
        for j, (servo, limit) in enumerate(zip(self._servos, self._limits, strict=True)):
            servo.engage()
            limit.engage(servo.position)
            self._target[j] = self._reference[j] = servo.position
        self._engaged = True
        return True

    def _may_start(self, run: int) -> bool:
        return self._motion is None and self._plan is not None and self._plan.run == run and run != self._started_run

    def _start(self) -> None:
        assert self._plan is not None
        self._motion = begin(self._plan, self._target, self._rates, self._accelerations, self._period_s)
        self._started_run = self._plan.run

    def _run(self, inputs: Inputs, motion: AnyMotion) -> Outputs:
        mode, driving = inputs.mode, NOT_DRIVEN
        if isinstance(motion, StreamMotion):
            motion.take(inputs.set_point)
            driving = motion.driving
        motion.advance(stop=mode != Mode.RUNNING)
        outputs = tuple([self._joint(j, motion) for j in range(len(self._servos))])
        if motion.done:
            self._motion = None
            self._target[:] = self._reference
        finished, stopped = motion.done and mode == Mode.RUNNING, motion.done and mode == Mode.STOPPING
        return Outputs(outputs, motion.segment, finished, stopped, self._tip_correction, NOT_DRIVEN if motion.done else driving)

    def _joint(self, j: int, motion: AnyMotion) -> JointOutput:
        servo, limit = self._servos[j], self._limits[j]
        reference = limit.apply(motion.reference[j], self._reference[j])
        rate = motion.reference_rate[j]
        if reference != motion.reference[j]:
            rate = clamp(rate, -limit.rate_limit, limit.rate_limit) if limit.low < reference < limit.high else 0.0
        self._target[j], self._reference[j], self._reference_rate[j] = motion.target[j], reference, rate
        servo.step(reference, rate, motion.volts[j], self._corrections[j], self._pushes[j])
        return JointOutput(motion.target[j], motion.target_rate[j], reference, rate, servo.velocity, servo.command_V)

    def _hold(self, inputs: Inputs) -> Outputs:
        outputs = []
        for j, servo in enumerate(self._servos):
            self._reference_rate[j] = 0.0
            servo.step(self._reference[j], 0.0, 0.0, self._corrections[j], self._pushes[j])
            outputs.append(JointOutput(self._target[j], 0.0, self._reference[j], 0.0, servo.velocity, servo.command_V))
        finished = inputs.mode == Mode.RUNNING and inputs.run == self._started_run and inputs.run != 0
        return Outputs(tuple(outputs), 0, finished, inputs.mode == Mode.STOPPING, self._tip_correction)

    def snapshot(self) -> dict[str, Any]:
        """The whole state as JSON-able values; floats keep every bit through JSON."""
        return {
            "version": SNAPSHOT_VERSION,
            "engaged": self._engaged,
            "target": [value if isfinite(value) else None for value in self._target],
            "reference": [value if isfinite(value) else None for value in self._reference],
            "reference_rate": list(self._reference_rate),
            "bounds": [[limit.low, limit.high] for limit in self._limits],
            "servos": [servo.snapshot() for servo in self._servos],
            "end_point": self._end_point.snapshot() if self._end_point is not None else None,
            "prepared": self._plan.request.as_json() if self._plan else None,
            "started_run": self._started_run,
            "motion": self._motion.snapshot() if self._motion else None,
            "motion_request": self._motion.plan.request.as_json() if self._motion else None,
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a snapshot bit for bit; runs are planned again from their requests.

        Raises ManeuverError for a snapshot of another version, or a run that this rig file does not allow.
        """
        if state.get("version") != SNAPSHOT_VERSION:
            raise ManeuverError("the controller state was written by another version", value=state.get("version"), limit=SNAPSHOT_VERSION)
        self._engaged = bool(state["engaged"])
        self._target = [nan if value is None else value for value in state["target"]]
        self._reference = [nan if value is None else value for value in state["reference"]]
        self._reference_rate = list(state.get("reference_rate", self._reference_rate))  # none in a log of an earlier version
        for limit, (low, high) in zip(self._limits, state["bounds"], strict=True):
            limit.low, limit.high = low, high
        for servo, saved in zip(self._servos, state["servos"], strict=True):
            servo.restore(saved)
        if self._end_point is not None and state.get("end_point") is not None:  # none in a log of a rig without it
            self._end_point.restore(state["end_point"])
        self._plan = self._planned(state["prepared"])
        self._started_run = state["started_run"]
        self._motion = None
        if state["motion"] is not None:
            same = state["motion_request"] == state["prepared"]
            plan = self._plan if same else self._planned(state["motion_request"])
            assert plan is not None
            self._motion = begin(plan, plan.start_position, self._rates, self._accelerations, self._period_s)
            self._motion.restore(state["motion"])

    def _planned(self, request: str | None) -> AnyPlan | None:
        return None if request is None else plan_any(self._rig, RunRequest.from_json(request))
