"""The text of a rig file for an arm: a turning joint, a sliding joint, and the tube that bends between hub and payload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from config.schema.end_point import EndPoint
from tuning.new_rig.arm import DAMPING_RATIO, TIP_ACCELERATION_M_PER_S2, Tube
from tuning.new_rig.axis import Axis
from tuning.new_rig.rig_text import (
    DEVICES,
    PLANT,
    Stated,
    effect_lines,
    head,
    interlock_lines,
    joint_lines,
    oil_lines,
    output_lines,
    plant_joint_lines,
    position_lines,
    pressure_lines,
    sensor_lines,
    servo_lines,
    signal_lines,
    supply_lines,
)  # fmt: skip

_G = 9.80665


@dataclass(frozen=True, slots=True)
class Deflection:
    """A sensor of the tip's deflection: its range either way (m), and all as the user wrote it."""

    most_m: float
    most: str
    resolution: str
    noise: str


@dataclass(frozen=True, slots=True)
class ArmStated:
    """What the user gave, as text: of both joints, of the tube by its keys in the file, and the deflection sensor if there is one.
    `feedback`: what was made for that sensor; None where it would not damp the link."""

    rotary: Stated
    prismatic: Stated
    link: Mapping[str, str]  # hub_inertia, carriage, payload, total_length, tube
    deflection: Deflection | None
    feedback: EndPoint | None = None


def arm_text(rotary: Axis, prismatic: Axis, tube: Tube, stated: ArmStated) -> str:
    """A whole rig file with the simulated plant as its device."""
    pairs = ((rotary, stated.rotary), (prismatic, stated.prismatic))
    found = [
        *head(stated.rotary.name, stated.rotary.description, "rotary_prismatic"),
        "joints:", *(line for pair in pairs for line in joint_lines(*pair)), "",
        "servo:", *(line for pair in pairs for line in servo_lines(*pair)), "",
        *_end_point(stated), "",
        *_link_mode(tube, stated),
        *DEVICES,
        "signals:", *_signals(rotary, prismatic, stated), "",
        "outputs:", *(line for _, one in pairs for line in output_lines(one)), "",
        "interlocks:", *interlock_lines(rotary), f"  tip_acceleration_max: {2 * TIP_ACCELERATION_M_PER_S2 / _G:.3g} g_0  # [A]", "",
        *PLANT,
        "  joints:", *(line for pair in pairs for line in plant_joint_lines(*pair)),
        *oil_lines(stated.rotary), *supply_lines(stated.rotary), *_link(tube, stated),
        "  sensors:", *_sensors(rotary, prismatic, stated),
        "  effects:", *(line for pair in pairs for line in effect_lines(*pair)),
        f"    - {{effect: link_flexibility, where: link, bending_stiffness: {tube.bending_stiffness:.6g} N*m^2,"
        f" damping_ratio: {DAMPING_RATIO:g}}}  # [D] {stated.link['tube']}; damping [A]",
    ]  # fmt: skip
    return "\n".join(found) + "\n"


def _end_point(stated: ArmStated) -> list[str]:
    feedback = stated.feedback
    if stated.deflection is None:
        return [
            "# No end-point feedback: no deflection sensor was given. `longreach new-rig --deflection-range` makes the section for one.",
            "# With the accelerometer alone, identify the link first: docs/guide/model/identify.md.",
        ]
    if feedback is None:
        return [
            "# No end-point feedback: on this file's plant it would not damp the link. `longreach identify` measures link and joint;",
            "# a section `end_point` by hand: docs/guide/model/identify.md.",
        ]
    return [
        "# The hub damps the link by what the deflection sensor reads. The servo's gain bears the link without it, if the sensor is lost.",
        "end_point:",
        "  source: deflection",
        f"  gain: {feedback.gain:.3g}  # [D] at most the whole; half of what leaves every mode damped, with none to 1.5 times the payload,",
        "  # and with the valve's gain 20 % higher or lower",
        f"  roll_off: {feedback.roll_off_Hz:g} Hz  # [A]",
        f"  full_below: {feedback.full_below_Hz:g} Hz  # [A] frequency of the link",
        f"  off_above: {feedback.off_above_Hz:g} Hz  # [A]",
    ]


def _link_mode(tube: Tube, stated: ArmStated) -> list[str]:
    return [
        "# What command filters and end-point feedback believe about the link.",
        "link_mode:",
        f"  bending_stiffness: {tube.bending_stiffness:.6g} N*m^2  # [D] {stated.link['tube']}",
        f"  mass_per_length: {tube.mass_per_length:.6g} kg/m  # [D]",
        f"  payload: {stated.link['payload']}  # [DS]",
        f"  damping_ratio: {DAMPING_RATIO:g}  # [A] identify it: docs/guide/model/identify.md",
        "",
    ]


def _link(tube: Tube, stated: ArmStated) -> list[str]:
    return [
        "  link:",
        f"    mass_per_length: {tube.mass_per_length:.6g} kg/m  # [D] {stated.link['tube']}",
        *(f"    {key}: {stated.link[key]}  # [DS]" for key in ("total_length", "hub_inertia", "carriage", "payload")),
    ]


def _signals(rotary: Axis, prismatic: Axis, stated: ArmStated) -> list[str]:
    return [
        *position_lines(rotary, stated.rotary), *position_lines(prismatic, stated.prismatic),
        *pressure_lines(rotary, stated.rotary), *pressure_lines(prismatic, stated.prismatic, supply=False),
        *signal_lines("tip.acceleration", "0.002 g_0", "-5.1 g_0", "5.1 g_0", "10 ms"),
        *(_deflection_signal(stated.deflection) if stated.deflection else []),
    ]  # fmt: skip


def _sensors(rotary: Axis, prismatic: Axis, stated: ArmStated) -> list[str]:
    seen = stated.deflection
    tip = "{resolution: 0.002 g_0, noise: 0.002 g_0, bandwidth: 100 Hz, low: -5 g_0, high: 5 g_0}"
    return [
        *sensor_lines(rotary, stated.rotary), *sensor_lines(prismatic, stated.prismatic, supply=False),
        f"    tip.acceleration: {tip}  # [A]",
        *([f"    tip.deflection: {_deflection_sensor(seen)}  # [DS]"] if seen else []),
    ]  # fmt: skip


def _deflection_signal(sensor: Deflection) -> list[str]:
    """Without it the arm goes on: nothing but the end-point feedback needs it."""
    end = f"{1020 * sensor.most_m:.5g} mm"
    return signal_lines("tip.deflection", sensor.resolution, f"-{end}", end, "10 ms", required=False)


def _deflection_sensor(sensor: Deflection) -> str:
    return f"{{resolution: {sensor.resolution}, noise: {sensor.noise}, low: -{sensor.most}, high: {sensor.most}}}"
