"""Hidden effects, each beside two first maneuvers that tell little about it, by bench: a rig and what is changed in its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gap.maneuvers.designs import ManeuverDesign

Case = str | tuple[str, str]  # an entry of plant.effects; or (effect, where): the rig file's own entry is taken out of the model


@dataclass(frozen=True, slots=True)
class LookAlikeBench:
    """A shipped rig, texts replaced in its file, the maneuvers of the first two logs (to fit, to decide), and what is hidden."""

    rig: str
    edits: tuple[tuple[str, str], ...]
    first: tuple[ManeuverDesign, ManeuverDesign]
    cases: tuple[Case, ...]


def _one_way(by: str, hold: str) -> ManeuverDesign:
    step = {"joint": "axis", "by": by, "speed": "0.06 m/s", "acceleration": "0.5 m/s^2", "hold": hold}
    return ManeuverDesign("joint_steps", {"start": {"axis": "0.02 m"}, "steps": [step, dict(step)]})


def _slow(amplitude: str, rate: str) -> ManeuverDesign:
    return ManeuverDesign(
        "slow_triangle", {"start": {"axis": "0.125 m"}, "joint": "axis", "cycles": 2, "amplitude": amplitude, "rate": rate}
    )


FORCE_AXIS = LookAlikeBench(
    "force_axis",
    (("{resolution: 1 um, ", "{resolution: 1 um, noise: 2 um, "),),  # as shipped its encoder has no noise
    (_slow("0.05 m", "0.05 m/s"), _slow("0.08 m", "0.08 m/s")),
    (
        "{effect: transport_delay, where: axis, delay: 4 ms}",
        "{effect: transport_delay, where: axis, delay: 8 ms}",
        "{effect: valve_lag, where: axis, time_constant: 4 ms, damping_ratio: 0.7}",
        "{effect: valve_lag, where: axis, time_constant: 3 ms, damping_ratio: 0.9}",
        "{effect: sensor_delay, where: 'sensor:axis.position', delay: 4 ms}",
        "{effect: inertia_error, where: axis, extra: 30 kg}",
        "{effect: valve_deadband, where: axis, overlap: 0.03}",
        "{effect: valve_hysteresis, where: axis, half_width: 0.02}",
        "{effect: stiction, where: axis, excess: 10 N, velocity: 5 mm/s}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 10 N, coefficient_difference: 0 N*s/m}",
        ("coulomb_friction", "axis"),
        ("viscous_friction", "axis"),
    ),
)

_SECOND_SIGNAL = """  axis.second_position:
    device: plant
    channel: axis.second_position
    calibration: {scale: 1 um}
    required: false

outputs:
"""
# Two noisy encoders: little is plain in the first logs, and a late command can be told from a late encoder.
TWO_ENCODERS = LookAlikeBench(
    "force_axis",
    (
        ("outputs:\n", _SECOND_SIGNAL),
        ("{resolution: 1 um, ", "{resolution: 1 um, noise: 20 um, "),
        ("  effects:\n", "    axis.second_position: {resolution: 1 um, noise: 20 um, low: -0.10 m, high: 0.35 m}\n  effects:\n"),
    ),
    (_slow("0.02 m", "0.02 m/s"), _slow("0.03 m", "0.03 m/s")),
    (
        "{effect: transport_delay, where: axis, delay: 4 ms}",
        "{effect: transport_delay, where: axis, delay: 8 ms}",
        "{effect: transport_delay, where: axis, delay: 2 ms}",
        "{effect: valve_lag, where: axis, time_constant: 3 ms, damping_ratio: 0.7}",
        "{effect: valve_lag, where: axis, time_constant: 4 ms, damping_ratio: 0.5}",
        "{effect: valve_lag, where: axis, time_constant: 2 ms, damping_ratio: 1.0}",
        "{effect: sensor_delay, where: 'sensor:axis.position', delay: 4 ms}",
        "{effect: sensor_delay, where: 'sensor:axis.position', delay: 8 ms}",
        "{effect: inertia_error, where: axis, extra: 20 kg}",
        "{effect: inertia_error, where: axis, extra: 40 kg}",
        "{effect: valve_deadband, where: axis, overlap: 0.01}",
        "{effect: valve_deadband, where: axis, overlap: 0.02}",
        "{effect: valve_deadband, where: axis, overlap: 0.04}",
        "{effect: valve_hysteresis, where: axis, half_width: 0.01}",
        "{effect: valve_hysteresis, where: axis, half_width: 0.02}",
        "{effect: valve_hysteresis, where: axis, half_width: 0.04}",
        "{effect: stiction, where: axis, excess: 10 N, velocity: 5 mm/s}",
        "{effect: stiction, where: axis, excess: 20 N, velocity: 5 mm/s}",
        "{effect: stiction, where: axis, excess: 20 N, velocity: 15 mm/s}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 8 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 16 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 0 N, coefficient_difference: 80 N*s/m}",
        "{effect: sensor_scale, where: 'sensor:axis.second_position', factor: 1.01}",
        "{effect: sensor_offset, where: 'sensor:axis.second_position', offset: 0.1 mm}",
        ("coulomb_friction", "axis"),
        ("viscous_friction", "axis"),
        ("valve_null_bias", "axis"),
    ),
)

# Both logs move one way at one speed: whatever pushes against that motion looks alike.
ONE_WAY = LookAlikeBench(
    "force_axis",
    TWO_ENCODERS.edits,
    (_one_way("0.08 m", "0.5 s"), _one_way("0.11 m", "0.7 s")),
    (
        ("coulomb_friction", "axis"),
        ("viscous_friction", "axis"),
        ("valve_null_bias", "axis"),
        "{effect: gravity, where: axis, tilt: 5 mrad}",
        "{effect: gravity, where: axis, tilt: 10 mrad}",
        "{effect: gravity, where: axis, tilt: -8 mrad}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 10 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 20 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 0 N, coefficient_difference: 200 N*s/m}",
        "{effect: valve_deadband, where: axis, overlap: 0.02}",
        "{effect: valve_deadband, where: axis, overlap: 0.04}",
        "{effect: valve_hysteresis, where: axis, half_width: 0.02}",
        "{effect: valve_hysteresis, where: axis, half_width: 0.04}",
        "{effect: stiction, where: axis, excess: 10 N, velocity: 5 mm/s}",
        "{effect: inertia_error, where: axis, extra: 20 kg}",
        "{effect: transport_delay, where: axis, delay: 6 ms}",
        "{effect: valve_lag, where: axis, time_constant: 3 ms, damping_ratio: 0.7}",
        "{effect: sensor_delay, where: 'sensor:axis.position', delay: 6 ms}",
        "{effect: sensor_delay, where: 'sensor:axis.position', delay: 2 ms}",
        "{effect: transport_delay, where: axis, delay: 3 ms}",
        "{effect: transport_delay, where: axis, delay: 4.5 ms}",
        "{effect: transport_delay, where: axis, delay: 8 ms}",
        "{effect: transport_delay, where: axis, delay: 10 ms}",
        "{effect: valve_lag, where: axis, time_constant: 1.5 ms, damping_ratio: 1.0}",
        "{effect: valve_lag, where: axis, time_constant: 2 ms, damping_ratio: 0.7}",
        "{effect: valve_lag, where: axis, time_constant: 2.5 ms, damping_ratio: 0.6}",
        "{effect: valve_lag, where: axis, time_constant: 3.5 ms, damping_ratio: 0.5}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 15 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: -20 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 30 N, coefficient_difference: 0 N*s/m}",
        "{effect: asymmetric_friction, where: axis, friction_difference: 20 N, coefficient_difference: 100 N*s/m}",
    ),
)

ORNL_TESTBED = LookAlikeBench(
    "ornl_testbed",
    (),
    (ManeuverDesign("paper_line"), ManeuverDesign("joint_steps")),
    (
        ("valve_lag", "rotary"),
        ("valve_lag", "prismatic"),
        ("hose_compliance", "rotary"),
        ("hose_compliance", "prismatic"),
        ("entrained_air", "rotary"),
        ("coulomb_friction", "prismatic"),
        ("stiction", "rotary"),
        ("cross_leakage", "prismatic"),
        "{effect: transport_delay, where: rotary, delay: 5 ms}",
        "{effect: sensor_delay, where: 'sensor:rotary.position', delay: 5 ms}",
        "{effect: valve_deadband, where: prismatic, overlap: 0.02}",
        "{effect: external_leakage, where: rotary, conductance: 2e-12 m^3/s/Pa}",
        ("coulomb_friction", "rotary"),
        ("viscous_friction", "rotary"),
        ("viscous_friction", "prismatic"),
        ("cross_leakage", "rotary"),
        "{effect: transport_delay, where: prismatic, delay: 4 ms}",
        "{effect: transport_delay, where: prismatic, delay: 8 ms}",
        "{effect: transport_delay, where: rotary, delay: 10 ms}",
        "{effect: sensor_delay, where: 'sensor:prismatic.position', delay: 6 ms}",
        "{effect: valve_deadband, where: rotary, overlap: 0.02}",
        "{effect: valve_null_bias, where: rotary, bias: 0.01}",
        "{effect: return_back_pressure, where: supply, pressure: 60 psi}",
        "{effect: payload_error, where: link, extra: 4 kg}",
    ),
)

BENCHES: Mapping[str, LookAlikeBench] = {
    "force_axis": FORCE_AXIS,
    "two_encoders": TWO_ENCODERS,
    "one_way": ONE_WAY,
    "ornl_testbed": ORNL_TESTBED,
}
