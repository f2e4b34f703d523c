"""Entries of `plant.effects` at a joint's mechanics. Forces and masses of a rotary joint are torques and inertias."""

from __future__ import annotations

from typing import Literal

from config.effect_entry import LINEAR, ROTARY, JointEntry, quantity_by_place
from config.section import quantity

FORCE = {ROTARY: "N*m", LINEAR: "N"}
VELOCITY = {ROTARY: "rad/s", LINEAR: "m/s"}
DAMPING = {ROTARY: "N*m*s/rad", LINEAR: "N*s/m"}
STIFFNESS = {ROTARY: "N*m/rad", LINEAR: "N/m"}
MASS = {ROTARY: "kg*m^2", LINEAR: "kg"}
LENGTH = {ROTARY: "rad", LINEAR: "m"}
PER_PRESSURE = {ROTARY: "N*m/Pa", LINEAR: "N/Pa"}


class CoulombFriction(JointEntry):
    effect: Literal["coulomb_friction"]
    friction: float = quantity_by_place(FORCE, "friction while sliding, whatever the speed", low=0, high=1e7)
    temperature_slope: float = quantity("1/K", "relative change per kelvin above 40 degC", 0.0, low=-0.02, high=0.02)


class Stiction(JointEntry):
    effect: Literal["stiction"]
    excess: float = quantity_by_place(FORCE, "breakaway friction beyond the friction while sliding", low=0, high=1e7)
    velocity: float = quantity_by_place(VELOCITY, "speed at which the excess has fallen to 1/e", low=1e-6, high=10)


class ViscousFriction(JointEntry):
    effect: Literal["viscous_friction"]
    coefficient: float = quantity_by_place(DAMPING, "friction per speed at 40 degC", low=0, high=1e7)
    oil_share: float = quantity("", "share of it that follows the oil's viscosity", 0.0, low=0, high=1)


class AsymmetricFriction(JointEntry):
    effect: Literal["asymmetric_friction"]
    friction_difference: float = quantity_by_place(FORCE, "sliding friction in positive minus negative direction", 0.0, low=-1e7, high=1e7)
    coefficient_difference: float = quantity_by_place(
        DAMPING, "friction per speed in positive minus negative direction", 0.0, low=-1e7, high=1e7
    )


class PressureFriction(JointEntry):
    effect: Literal["pressure_friction"]
    coefficient: float = quantity_by_place(PER_PRESSURE, "seal friction per pressure difference between the chambers", low=0, high=1)


class Backlash(JointEntry):
    effect: Literal["backlash"]
    gap: float = quantity_by_place(LENGTH, "total free play between actuator and load; 0 is a rigid drive train", low=0, high=0.2)
    stiffness: float = quantity_by_place(STIFFNESS, "drive train in contact", low=1, high=1e9)
    damping: float = quantity_by_place(DAMPING, "drive train in contact", 0.0, low=0, high=1e6)
    actuator_mass: float = quantity_by_place(MASS, "share of the joint's mass or inertia on the actuator's side", low=1e-9, high=1e5)
    sensor_on: Literal["actuator", "load"] = "load"


class InertiaError(JointEntry):
    effect: Literal["inertia_error"]
    extra: float = quantity_by_place(MASS, "mass or inertia that moves with the joint beyond the plant's own", low=-1e4, high=1e5)


class Gravity(JointEntry):
    """The plane of motion is tilted; for an arm one entry at either joint tilts the whole arm."""

    effect: Literal["gravity"]
    tilt_rad: float = quantity("rad", "angle of the plane of motion to the horizontal, its far end (rotary 0) up", low=-1.6, high=1.6)
    unbalance_N_m: float = quantity("N*m", "weight times arm about the axis; only for a single rotary axis", 0.0, low=0, high=1e6)


JOINT_EFFECTS = (
    CoulombFriction,
    Stiction,
    ViscousFriction,
    AsymmetricFriction,
    PressureFriction,
    Backlash,
    InertiaError,
    Gravity,
)
