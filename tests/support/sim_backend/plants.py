"""Rigs for the tests of the simulated plant: variants of the shipped ones, made from their text."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from config.loading.load import find, rig_from_text
from config.schema.rig import Rig
from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, C, D, J, Kind
from sim_backend.plant import SimulatedRig

INCH_M = 0.0254
POUND_KG = 0.45359237
PSI_PA = 6894.757
SUPPLY_PA = 2000 * 6894.757293168
EQ4_NUMERATOR, EQ4_DAMPING, EQ4_STIFFNESS = 240810.0, 140.0, 6150.0  # deg/s per V: N / (s² + 140 s + 6150)

Content = dict[str, Any]


def variant(name: str, *changes: Callable[[Content], None]) -> Rig:
    """A shipped rig with changes made to the content of its file."""
    content: Content = yaml.safe_load(find("rigs", name).read_text(encoding="utf-8"))
    for change in changes:
        change(content)
    return rig_from_text(yaml.safe_dump(content, sort_keys=False), f"{name} (variant)")


def ornl(*changes: Callable[[Content], None]) -> Rig:
    return variant("ornl_testbed", *changes)


def without(*names: str) -> Callable[[Content], None]:
    """Delete these effects everywhere."""

    def change(content: Content) -> None:
        content["plant"]["effects"] = [entry for entry in content["plant"]["effects"] if entry["effect"] not in names]

    return change


def ideal(content: Content) -> None:
    """No effects at all, and valves with their null in the middle."""
    content["plant"]["effects"] = []
    centred_null(content)


def centred_null(content: Content) -> None:
    """As set R has it: the shipped rig's prismatic valve is adjusted so that the cylinder stands at 0 V."""
    for joint in content["plant"]["joints"].values():
        joint.get("valve", {})["null_adjustment"] = 0.0


def with_effects(*entries: Content) -> Callable[[Content], None]:
    """Add effects; one that is already there is replaced."""

    def change(content: Content) -> None:
        new = {(entry["effect"], entry["where"]) for entry in entries}
        kept = [entry for entry in content["plant"]["effects"] if (entry["effect"], entry["where"]) not in new]
        content["plant"]["effects"] = [*kept, *entries]

    return change


def isothermal(content: Content) -> None:
    del content["plant"]["thermal"]


def quiet(content: Content) -> None:
    """Ideal sensors: no noise, bias, lag."""
    for sensor in content["plant"]["sensors"].values():
        for key in ("noise", "bias", "bandwidth"):
            sensor.pop(key, None)


def unloaded_inertia_13(content: Content) -> None:
    """The arm of the identification of Eq 4: rigid, no payload, 36 in, 13.0 kg m² in all."""
    without("link_flexibility")(content)
    extension, tube, line = 36 * INCH_M, 1.80, 2.545698
    own = line / 3 * (extension**3 + (tube - extension) ** 3)
    content["plant"]["link"] |= {"payload": 0, "hub_inertia": 13.0 - own}
    content["plant"]["joints"]["prismatic"]["initial"] = "36 in"


def slot(joint: int, index: J) -> int:
    """Position of a joint's entry in the parameter vector; 0 rotary, 1 prismatic."""
    return J_START + joint * J_STRIDE + index


def mechanics_only(sim: SimulatedRig) -> None:
    """Turn both joints into frictionless force actuators of 1 N(m)/V without stops, and the oil off."""
    p = sim.parameters.values
    for joint in (0, 1):
        p[slot(joint, J.KIND)] = Kind.FORCE
        p[slot(joint, J.FORCE_GAIN)] = 1.0
        p[slot(joint, J.FULL_SCALE)] = 1.0
        p[slot(joint, J.SATURATION)] = 1e15
        p[slot(joint, J.SLEW_RATE)] = 1e30
        p[slot(joint, J.LOW)], p[slot(joint, J.HIGH)] = -1e9, 1e9
        for index in (J.COULOMB, J.STICTION, J.VISCOUS, J.VALVE_TIME, J.HYSTERESIS, J.NULL_BIAS, J.NULL_ADJUSTMENT):
            p[slot(joint, index)] = 0.0
    p[C.THERMAL] = 0.0


def set_motion(sim: SimulatedRig, joint: int, position: float, velocity: float) -> None:
    sim.state[joint * D_STRIDE + D.POSITION] = position
    sim.state[joint * D_STRIDE + D.VELOCITY] = velocity


def sine_gain(signal: NDArray[np.float64], t: NDArray[np.float64], frequency_Hz: float) -> complex:
    """First harmonic of a signal as the complex factor on sin(ωt), by least squares."""
    phase = 2 * np.pi * frequency_Hz * t
    basis = np.column_stack([np.sin(phase), np.cos(phase), np.ones_like(t), t - t.mean()])
    in_phase, quadrature, *_ = np.linalg.lstsq(basis, signal, rcond=None)[0]
    return complex(in_phase, quadrature)


def eq4(frequency_Hz: float) -> complex:
    """Eq 4 of the paper: rotary velocity per command, rad/s per V."""
    s = 2j * np.pi * frequency_Hz
    return complex(np.deg2rad(EQ4_NUMERATOR) / (s * s + EQ4_DAMPING * s + EQ4_STIFFNESS))


def rotary_response(sim: SimulatedRig, amplitude_V: float, frequency_Hz: float, temperature_C: float | None = None) -> complex:
    return joint_response(sim, "rotary", amplitude_V, frequency_Hz, temperature_C)


def joint_response(
    sim: SimulatedRig,
    joint: str,
    amplitude_V: float,
    frequency_Hz: float,
    temperature_C: float | None = None,
    positions: list[float] | None = None,
) -> complex:
    """Velocity of a joint per command (rad/s or m/s per V): first harmonic after three periods of settling."""
    period_s = 1e-3
    sim.reset(positions=positions, temperature_C=temperature_C)
    settle, measured = 3 / frequency_Hz, max(4 / frequency_Hz, 1.0)
    measured = np.ceil(measured * frequency_Hz) / frequency_Hz
    t = np.arange(round((settle + measured) / period_s)) * period_s
    commands = np.zeros((t.size, len(sim.joints)))
    commands[:, sim.joints.index(joint)] = amplitude_V * np.sin(2 * np.pi * frequency_Hz * t)
    velocity = sim.run(commands, period_s)[f"{joint}.velocity"]
    late = t >= settle
    # the command is held over each period: half a period of delay belongs to the sampling, not to the joint
    return sine_gain(velocity[late], t[late], frequency_Hz) / amplitude_V * np.exp(1j * np.pi * frequency_Hz * period_s)
