"""Whether the servo of a rig file can hold its joint: signs, corners against the loop's rate, gain against what the joint gives."""

from __future__ import annotations

import math
from collections.abc import Iterator

from config.checking.actuator_sizes import actuator_sizes
from config.checking.finding import Finding, warning_at
from config.parsing.yaml_tree import YamlTree, dotted
from config.schema.plant_joint import ForceActuator, TorqueActuator
from config.schema.rig import Rig
from config.schema.servo import JointServo

_FREQUENCIES = [10.0 ** (6.0 - 0.01 * k) for k in range(900)]  # rad/s, from above
LOST_PHASE_RAD = 0.5  # a loop that loses more to its own delay of 1.5 cycles has little margin left


def check_servo(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about `servo`."""
    for name in rig.servo:
        yield from _signs(rig, tree, name)
        yield from _corners(rig, tree, name)
        yield from _crossover(rig, tree, name)


def _direction(rig: Rig, name: str) -> float:
    """Sign of the motion that a positive command makes, as far as the file knows: the simulated drive, if it is one, else the output."""
    joint = rig.plant.joints.get(name) if rig.plant else None
    drive = joint.gain_N_per_V if isinstance(joint, ForceActuator) else joint.gain_N_m_per_V if isinstance(joint, TorqueActuator) else 1.0
    return math.copysign(1.0, drive) * math.copysign(1.0, rig.outputs[name].scale)


def _signs(rig: Rig, tree: YamlTree, name: str) -> Iterator[Finding]:
    servo, path = rig.servo[name], ("servo", name, "gain")
    unit = rig.joints[name].position_unit
    gain = f"servo.{name}.gain is {servo.gain:.4g} V/{unit}"
    if servo.gain == 0:
        yield warning_at(tree, path, f"{gain}: nothing holds the joint")
    elif servo.gain * _direction(rig, name) < 0 and not _is_imposed(rig, name):
        what = "with outputs and drive as they stand here the joint runs away from its reference"
        yield warning_at(tree, path, f"{gain}: {what}, unless valve or sensor is connected the other way round")
    if servo.gain * servo.velocity_feedforward < 0:
        text = f"servo.{name}.velocity_feedforward is {servo.velocity_feedforward:.4g} V*s/{unit}, the gain {servo.gain:.4g} V/{unit}"
        yield warning_at(tree, ("servo", name, "velocity_feedforward"), f"{text}: one drives against the other")


def _is_imposed(rig: Rig, name: str) -> bool:
    joint = rig.plant.joints.get(name) if rig.plant else None
    return joint is not None and joint.is_imposed


def _corners(rig: Rig, tree: YamlTree, name: str) -> Iterator[Finding]:
    """A corner above half the loop's rate is not where it is written."""
    servo, highest_Hz = rig.servo[name], 0.5 * rig.loop.rate_Hz
    corners: list[tuple[tuple[str | int, ...], float]] = [(("velocity_filter",), servo.velocity_filter_Hz)]
    for number, section in enumerate(servo.sections):
        corners.append((("sections", number, "zero"), section.zero_rad_per_s / (2 * math.pi)))
        corners.append((("sections", number, "pole"), section.pole_rad_per_s / (2 * math.pi)))
    for key, corner_Hz in corners:
        if corner_Hz > highest_Hz:
            path = ("servo", name, *key)
            text = f"{dotted(path)} is {corner_Hz:.4g} Hz, above half the loop's rate, {highest_Hz:g} Hz: it acts elsewhere"
            yield warning_at(tree, path, text)


def _last_crossing(servo: JointServo, constant: float) -> float:
    """Highest frequency (rad/s) at which |C(jω) constant / (jω)| is 1, C the servo's sections; `constant` itself without any."""
    if not servo.sections:
        return constant

    def loop_gain(w: float) -> float:
        corners = ((section.zero_rad_per_s, section.pole_rad_per_s) for section in servo.sections)
        return constant / w * math.prod(math.hypot(1.0, w / zero) / math.hypot(1.0, w / pole) for zero, pole in corners)

    return next((w for w in _FREQUENCIES if loop_gain(w) >= 1.0), 0.0)


def _crossover(rig: Rig, tree: YamlTree, name: str) -> Iterator[Finding]:
    """Gain times speed per volt is the frequency (rad/s) up to which the loop follows; lags and leads change that."""
    sizes = actuator_sizes(rig, name)
    if sizes is None:
        return
    path = ("servo", name, "gain")
    constant = abs(rig.servo[name].gain) * sizes.full_speed / sizes.full_scale_V
    crossover = _last_crossing(rig.servo[name], constant)
    per_V = f"gain {rig.servo[name].gain:.4g} V/{sizes.unit} times {sizes.full_speed / sizes.full_scale_V:.3g} {sizes.unit}/s/V"
    crossover_Hz = crossover / (2 * math.pi)  # not in rad/s, which would be shown as the deg/s in which a joint is stated
    text = f"servo.{name}: {per_V} is a velocity constant of {constant:.3g} 1/s and crosses over at {crossover_Hz:.3g} Hz"
    if crossover_Hz > sizes.natural_frequency_Hz:
        limit = f"the natural frequency of mass and oil, {sizes.natural_frequency_Hz:.3g} Hz"
        yield warning_at(tree, path, f"{text}, above {limit}: unstable")
    if 1.5 * crossover / rig.loop.rate_Hz > LOST_PHASE_RAD:
        lost_deg = math.degrees(1.5 * crossover / rig.loop.rate_Hz)
        yield warning_at(tree, path, f"{text}; the loop at {rig.loop.rate_Hz:g} Hz loses {lost_deg:.0f} deg of phase there")
