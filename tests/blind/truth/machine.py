"""Every number of the hidden machine, as the integrator needs it: flat named tuples of floats, SI, temperatures in degC."""

from __future__ import annotations

from typing import NamedTuple


class Joint(NamedTuple):
    """One hydraulic joint; forces and lengths stand for torques and angles in the rotary one."""

    area_a: float
    area_b: float
    volume_a: float  # at `volume_at`
    volume_b: float
    volume_at: float
    low: float
    high: float
    stop_stiffness: float
    flow: float  # m³/s/√Pa at full opening, one land
    full_scale: float
    slew: float
    rounding: float
    laminar: float
    null: float
    null_drift: float
    lag: float  # s; 0: the spool follows at once
    lag_damping: float
    overlap: float
    hysteresis: float
    saturation: float
    asymmetry: float
    delay: float
    cross: float
    external: float
    bulk_slope: float
    hose_slope: float
    air: float
    hose: float
    coulomb: float
    coulomb_slope: float
    stiction: float
    stribeck: float
    viscous: float
    viscous_share: float
    coulomb_difference: float
    viscous_difference: float
    pressure_friction: float
    bristle: float
    bristle_damping: float
    fade: float
    extra_mass: float
    gap: float
    drive_stiffness: float
    drive_damping: float
    actuator_mass: float
    # outside the finder's library
    ripple: float  # of the Coulomb friction over the position, relative
    pitch: float
    command_step: float  # V; 0: continuous
    curvature: float  # flow per opening grows with it


class Machine(NamedTuple):
    rotary: Joint
    prismatic: Joint
    friction_form: float  # see blind.truth.friction
    hub_offset: float
    hub_inertia: float
    mass_per_length: float
    tube_length: float
    carriage: float
    payload: float
    bending: float
    damping: float
    gravity: float
    supply: float
    tank: float
    tank_resistance: float
    line_resistance: float
    line_rate: float
    inverse_gas: float
    pump_flow: float
    pump_band: float
    pump_lag: float
    relief: float
    relief_gain: float
    bulk: float
    bulk_pressure: float
    vapour: float
    viscosity_a: float
    viscosity_b: float
    # outside the finder's library
    bracket_mass: float  # of the payload, hung on a spring
    bracket_rate: float  # its natural frequency, rad/s
    bracket_damping: float
    pulsation: float  # of the supply pressure, relative
    pulsation_Hz: float
