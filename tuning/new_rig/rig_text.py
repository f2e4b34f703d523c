"""The text of a rig file for one hydraulic axis: every number with where it comes from, in the words and units the user gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, pi

from tuning.new_rig.axis import BULK_MODULUS_PA, Axis


@dataclass(frozen=True, slots=True)
class Stated:
    """What the user gave, as text for the file. `size`: lines of the actuator's size; `iso_vg`: grade of the oil; `assumed`: what was
    not given, by its name here."""

    name: str
    description: str
    joint: str
    size: Mapping[str, str]
    mass: str
    rated_flow: str
    rated_drop: str
    full_scale: str
    stroke_time: str
    supply: str
    iso_vg: int
    position: Mapping[str, str]  # resolution, noise
    chamber_pressures: bool
    assumed: frozenset[str] = frozenset()

    def tag(self, name: str) -> str:
        return "[A]" if name in self.assumed else "[DS]"


def rig_text(axis: Axis, stated: Stated) -> str:
    """A whole rig file with the simulated plant as its device."""
    found = [
        *head(stated.name, stated.description, "single_axis"),
        "joints:", *joint_lines(axis, stated), "",
        "servo:", *servo_lines(axis, stated), "",
        *DEVICES,
        "signals:", *position_lines(axis, stated), *pressure_lines(axis, stated), "",
        "outputs:", *output_lines(stated), "",
        "interlocks:", *interlock_lines(axis), "",
        *PLANT,
        "  joints:", *plant_joint_lines(axis, stated), *oil_lines(stated), *supply_lines(stated),
        "  sensors:", *sensor_lines(axis, stated),
        "  effects:", *effect_lines(axis, stated),
    ]  # fmt: skip
    return "\n".join(found) + "\n"


def length(axis: Axis, value: float, per: str = "") -> str:
    """In deg or mm, which people read."""
    return f"{degrees(value):.5g} deg{per}" if axis.rotary else f"{1e3 * value:.5g} mm{per}"


def head(name: str, description: str, kind: str) -> list[str]:
    return [
        f"# {description}",
        "#",
        "# Written by `longreach new-rig`. Where the numbers come from: [DS] data sheet or as you gave it, [C] typical of the",
        "# component family, [D] derived from other entries, [A] assumed. Look at every [A] before the rig moves.",
        "longreach: rig/1",
        f"name: {name}",
        f"description: {description}",
        "",
        "arm:",
        f"  kind: {kind}",
        "",
        "loop:",
        "  rate: 1 kHz                         # [A]",
        "  countdown: 3 s                      # [A]",
        "",
    ]


DEVICES = (
    "# The simulated rig stands in for the devices. With real ones: docs/guide/rig/wiring.md.",
    "devices:",
    "  plant:",
    "    driver: sim",
    "    timeout: 70 ms                    # [A]",
    "",
)
PLANT = (
    "# The simulated rig: the ideal machine, then under `effects` what is not ideal about it.",
    "plant:",
    "  step: 0.25 ms                       # [A]",
)


def joint_lines(axis: Axis, stated: Stated) -> list[str]:
    inside = 0.02 * axis.stroke
    out, back = axis.speeds
    return [
        f"  {stated.joint}:",
        f"    motion: {'rotary' if axis.rotary else 'linear'}",
        f"    travel: [{length(axis, axis.low + inside)}, {length(axis, axis.high - inside)}]  # [A] 2 % inside the stops",
        f"    rate_limit: {length(axis, axis.rate_limit, '/s')}  # [D] {_why_rate(axis)}; full speed {length(axis, out, '/s')} out and"
        f" {length(axis, back, '/s')} back",
        f"    acceleration_limit: {length(axis, axis.acceleration_limit, '/s^2')}  # [D] 0.3 of the force at most, gentle to the resonance",
        f"    following_error_limit: {length(axis, 0.05 * axis.stroke)}  # [A] a twentieth of the stroke",
        f"    command_limit: {stated.full_scale}  # {stated.tag('full_scale')} full opening",
        f"    command_rate_limit: {2 * axis.full_scale_V / axis.stroke_time_s:.4g} V/s  # [A] twice what the spool can follow",
    ]


def _why_rate(axis: Axis) -> str:
    return "half of full speed" if axis.rate_limit < axis.rate_cap else "the tip's speed at the longest extension"


def servo_lines(axis: Axis, stated: Stated) -> list[str]:
    unit, turn = ("deg", pi / 180) if axis.rotary else ("m", 1.0)
    capped = axis.loop_gain_1_s == axis.loop_gain_cap_1_s
    why = (
        ["    # half of what the link bears at any extension, with and without payload"]
        if capped
        else [
            f"    # half of what the resonance of oil and mass, {axis.natural_frequency_rad_s / (2 * pi):.3g} Hz, bears with damping 0.1,",
            "    # or half of what the valve's stroke time bears",
        ]
    )
    return [
        f"  {stated.joint}:",
        f"    gain: {axis.gain * turn:.4g} V/{unit}  # [D] {axis.loop_gain_1_s:.3g} 1/s over {axis.velocity_gain / turn:.3g} {unit}/s/V",
        *why,
        f"    velocity_feedforward: {turn / axis.velocity_gain:.5g} V*s/{unit}  # [D] the inverse of the speed per volt",
        "    velocity_filter: 50 Hz            # [A]",
        f"    # oil_compensation: `longreach oil-table {stated.name}.yaml --joint {stated.joint}` prints its table from this file's plant;",
        f"    # it needs a signal {stated.joint}.return_temperature",
    ]


def position_lines(axis: Axis, stated: Stated) -> list[str]:
    margin = 0.05 * axis.stroke
    ends = length(axis, axis.low - margin), length(axis, axis.high + margin)
    return signal_lines(f"{stated.joint}.position", stated.position["resolution"], *ends, "5 ms")


def pressure_lines(axis: Axis, stated: Stated, *, supply: bool = True) -> list[str]:
    joint, found = stated.joint, list[str]()
    pressures = [*([f"{joint}.supply_pressure"] if supply else []), *_chambers(stated)]
    for name in pressures:
        found += signal_lines(name, "0.05 bar", "-5 bar", _full_scale_bar(axis), "15 ms", required=name.endswith("supply_pressure"))
    return found


def _chambers(stated: Stated) -> list[str]:
    return [f"{stated.joint}.pressure_a", f"{stated.joint}.pressure_b"] if stated.chamber_pressures else []


def output_lines(stated: Stated) -> list[str]:
    joint = stated.joint
    return [
        f"  {joint}:",
        "    device: plant",
        f"    channel: {joint}.command",
        "    scale: 1.0                        # volts in, volts out",
    ]


def interlock_lines(axis: Axis) -> list[str]:
    return [
        f"  supply_pressure_min: {0.75e-5 * axis.supply:.4g} bar  # [A] three quarters of the stated pressure",
        f"  supply_pressure_max: {1.2e-5 * axis.supply:.4g} bar  # [A] 1.2 of it",
    ]


def signal_lines(name: str, resolution: str, low: str, high: str, age: str, *, required: bool = True) -> list[str]:
    return [
        f"  {name}:",
        "    device: plant",
        f"    channel: {name}",
        f"    calibration: {{scale: {resolution}}}",
        f"    low: {low}  # [A]",
        f"    high: {high}  # [A]",
        f"    max_age: {age}  # [A]",
        *([] if required else ["    required: false"]),
    ]


def _full_scale_bar(axis: Axis) -> str:
    return f"{1.5e-5 * axis.supply:.4g} bar"


def plant_joint_lines(axis: Axis, stated: Stated) -> list[str]:
    force, torque = ("N*m", "rad") if axis.rotary else ("N", "m")
    mass = [f"      {'inertia' if axis.rotary else 'mass'}: {stated.mass}  # [DS]"] if stated.mass else []
    return [
        f"    {stated.joint}:",
        f"      actuator: {'rotary' if axis.rotary else 'cylinder'}",
        f"      travel: [{length(axis, axis.low)}, {length(axis, axis.high)}]  # [DS]",
        f"      initial: {length(axis, 0.5 * (axis.low + axis.high))}  # [A] mid stroke",
        *(f"      {key}: {value}" for key, value in stated.size.items()),
        *mass,
        f"      bristle_stiffness: {axis.bristle_stiffness:.3g} {force}/{torque}  # [A]",
        f"      bristle_damping: {axis.bristle_damping:.3g} {force}*s/{torque}  # [D]",
        f"      bristle_fade: {length(axis, 0.01 * axis.rate_limit, '/s')}  # [A]",
        "      valve:",
        f"        rated_flow: {stated.rated_flow}  # [DS]",
        f"        rated_pressure_drop: {stated.rated_drop}  # {stated.tag('rated_drop')} over both lands",
        f"        full_scale: {stated.full_scale}  # {stated.tag('full_scale')}",
        f"        stroke_time: {stated.stroke_time}  # {stated.tag('stroke_time')}",
        "        null_rounding: 0.0165         # [C]",
    ]


def oil_lines(stated: Stated) -> list[str]:
    return [
        "  oil:",
        "    density: 870 kg/m^3               # [C] mineral oil",
        "    specific_heat: 1900 J/kg/K        # [C]",
        f"    bulk_modulus: {BULK_MODULUS_PA / 1e9:.3g} GPa  # [C] under pressure, hoses and a little air counted in",
        f"    iso_vg: {stated.iso_vg}  # {stated.tag('iso_vg')}",
        "    initial_temperature: 40 degC      # [A]",
    ]


def supply_lines(stated: Stated) -> list[str]:
    return ["  supply:", f"    pressure: {stated.supply}  # [DS]", "    return_pressure: 2 bar            # [A]"]


def sensor_lines(axis: Axis, stated: Stated, *, supply: bool = True) -> list[str]:
    joint, margin = stated.joint, 0.04 * axis.stroke
    ends = f"low: {length(axis, axis.low - margin)}, high: {length(axis, axis.high + margin)}"
    pressure = f"{{resolution: 0.05 bar, noise: 0.3 bar, bandwidth: 500 Hz, low: 0 bar, high: {_full_scale_bar(axis)}}}  # [A]"
    return [
        f"    {joint}.position: {{resolution: {stated.position['resolution']}, noise: {stated.position['noise']}, {ends}}}",
        *([f"    {joint}.supply_pressure: {pressure}"] if supply else []),
        *(f"    {name}: {pressure}" for name in _chambers(stated)),
    ]


def effect_lines(axis: Axis, stated: Stated) -> list[str]:
    force, torque = ("N*m", "rad") if axis.rotary else ("N", "m")
    effects = {
        "coulomb_friction": f"friction: {axis.friction:.4g} {force}}}  # [C] 3 % of the largest force",
        "stiction": f"excess: {0.25 * axis.friction:.3g} {force}, velocity: {length(axis, 0.005 * axis.rate_limit, '/s')}}}  # [A]",
        "viscous_friction": f"coefficient: {axis.viscous:.4g} {force}*s/{torque}}}  # [A] as much at the rate limit",
        "valve_lag": f"time_constant: {0.25e3 * axis.stroke_time_s:.3g} ms, damping_ratio: 0.8}}  # [C] a quarter of the stroke time",
        "cross_leakage": f"conductance: {axis.leakage:.3g} m^3/s/Pa}}  # [C] 0.2 % of the rated flow at supply pressure",
    }
    return [f"    - {{effect: {effect}, where: {stated.joint}, {rest}" for effect, rest in effects.items()]
