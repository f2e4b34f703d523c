"""Release tests on the simulated rig: the joint let go some degrees from its reference, servo and end-point feedback as they run."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, nan, radians

import numpy as np

from config.schema.end_point import EndPoint
from config.schema.rig import Rig
from config.schema.servo import LagLeadSection
from servo_control.link.end_point import EndPointFeedback
from servo_control.servo.link_notch import link_notch
from servo_control.servo.servo import JointServo
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.linear.closed_loop import Servo
from tuning.variants import PRISMATIC, ROTARY, plant_of, with_link

RELEASE_RAD = radians(2.0)
LAST_S = 5.0  # what is left at the end is measured over these seconds
AT_REST_RAD = radians(0.02)


@dataclass(frozen=True, slots=True)
class Release:
    """Joint angle (rad), tip deflection (m) over time, and what is left over the last seconds: amplitudes are half peak to peak."""

    t_s: Floats
    angle: Floats
    deflection_m: Floats
    frequency_Hz: float
    angle_amplitude_deg: float
    tip_amplitude_m: float

    @property
    def oscillates(self) -> bool:
        return self.angle_amplitude_deg > degrees(AT_REST_RAD)


@dataclass(frozen=True, slots=True)
class ReleaseConditions:
    """Where and with what the arm is released. `temperature_C` None: that of the rig file."""

    extension_m: float
    payload_kg: float
    temperature_C: float | None = None


def release(rig: Rig, place: ReleaseConditions, servo: Servo, seconds: float = 20.0, angle: float = RELEASE_RAD) -> Release:
    """Let go at `angle` with reference 0; both joints' servos run, the prismatic one as in the rig file, sensors are ideal."""
    plant = SimulatedRig(with_link(rig, payload_kg=place.payload_kg))
    plant.reset([angle, place.extension_m], place.temperature_C)
    period_s = 1.0 / rig.loop.rate_Hz
    rotary, prismatic = _rotary_servo(rig, servo, period_s), JointServo(rig.joints[PRISMATIC], rig.servo[PRISMATIC], period_s)
    feedback = _feedback(rig, servo, period_s)
    sign = -1.0 if servo.tip_gain < 0.0 else 1.0
    oil_C = _oil_C(rig) if place.temperature_C is None else place.temperature_C
    count = round(seconds / period_s)
    angles, tips = np.empty(count), np.empty(count)
    for n in range(count):
        angles[n], extension = plant.true_position
        tips[n] = plant.true_signal("tip.deflection")
        rotary.measure(float(angles[n]))
        prismatic.measure(extension)
        measured, planned = (extension, prismatic.velocity, rotary.velocity), (place.extension_m, 0.0, 0.0)
        rotary.measure_oil(oil_C)
        rotary.follow_extension(extension)
        correction = sign * feedback.step((float(tips[n]), nan), measured, planned) if feedback else 0.0
        rotary.step(0.0, 0.0, 0.0, correction, feedback.push(correction) if feedback else 0.0)
        prismatic.step(place.extension_m, 0.0, 0.0)
        plant.advance([rotary.command_V, prismatic.command_V], period_s)
    return _judged(np.arange(count, dtype=np.float64) * period_s, angles, tips, period_s)


def _oil_C(rig: Rig) -> float:
    oil = plant_of(rig).oil
    return oil.initial_temperature_C if oil is not None else nan


def servo_of(rig: Rig) -> Servo:
    """The rotary servo of the rig file."""
    servo, feedback = rig.servo[ROTARY], rig.end_point
    sections = tuple((section.zero_rad_per_s, section.pole_rad_per_s) for section in servo.sections)
    return Servo(servo.gain, sections, feedback.gain, feedback.roll_off_Hz) if feedback is not None else Servo(servo.gain, sections)


def _rotary_servo(rig: Rig, servo: Servo, period_s: float) -> JointServo:
    settings = rig.servo[ROTARY]
    sections = tuple(LagLeadSection.model_validate({"zero": zero, "pole": pole}) for zero, pole in servo.sections)
    changed = settings.model_copy(update={"gain": servo.gain, "sections": sections})
    return JointServo(rig.joints[ROTARY], changed, period_s, link_notch(rig))


def _feedback(rig: Rig, servo: Servo, period_s: float) -> EndPointFeedback | None:
    """The running feedback with the payload that the rig file believes in; a negative gain (true tip) is the same feedback with its sign
    reversed."""
    if servo.tip_gain == 0.0 or rig.link_mode is None:
        return None
    base = rig.end_point or EndPoint()
    settings = base.model_copy(update={"gain": abs(servo.tip_gain), "roll_off_Hz": servo.roll_off_Hz})
    return EndPointFeedback(settings, rig.link_mode, rig.joints[PRISMATIC].travel, period_s)


def _judged(t: Floats, angles: Floats, tips: Floats, period_s: float) -> Release:
    last = slice(-round(LAST_S / period_s), None)
    swing = angles[last] - np.mean(angles[last])
    rising = np.flatnonzero((swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    steps = rising - swing[rising] / (swing[rising + 1] - swing[rising])  # crossings between samples
    frequency = (len(steps) - 1) / ((steps[-1] - steps[0]) * period_s) if len(steps) > 2 else 0.0
    return Release(t, angles, tips, float(frequency), degrees(0.5 * float(np.ptp(angles[last]))), 0.5 * float(np.ptp(tips[last])))
