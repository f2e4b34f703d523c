"""How every kind of effect is searched: the balance equation it enters, what is free in it, its plausible range and where fits start."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gap.search.sizes import Sizes


@dataclass(frozen=True, slots=True)
class Freedom:
    """One free parameter of an effect: typical size, plausible range, and the sizes (in typical ones) from which fits start."""

    parameter: str
    typical: Callable[[Sizes], float]
    low: Callable[[Sizes], float]
    high: Callable[[Sizes], float]
    starts: tuple[float, ...] = (1.0,)


@dataclass(frozen=True, slots=True)
class Shape:
    """How a kind of effect is searched: free parameters, fixed ones, and the balance equation it enters."""

    equation: str
    free: tuple[Freedom, ...]
    fixed: Mapping[str, Callable[[Sizes], float]]


def _nothing(_: Sizes) -> float:
    return 0.0


def _up(parameter: str, typical: Callable[[Sizes], float], most: float, starts: tuple[float, ...] = (1.0,)) -> Freedom:
    """A parameter that is never negative, up to `most` typical sizes."""
    return Freedom(parameter, typical, _nothing, lambda s: most * typical(s), starts)


def _both(parameter: str, typical: Callable[[Sizes], float], most: float) -> Freedom:
    """A parameter of either sign."""
    return Freedom(parameter, typical, lambda s: -most * typical(s), lambda s: most * typical(s), (1.0, -1.0))


def _damping(s: Sizes) -> float:
    return 0.03 * s.force / s.velocity


def _leak(s: Sizes) -> float:
    return 0.02 * s.area * s.velocity / s.pressure


FORCE, VALVE, FLOW, SUPPLY, LINK, SENSOR = (
    "force balance", "valve command to spool", "chamber flow balance", "supply", "link bending", "sensor",
)  # fmt: skip

# A link whose frequency is off by a tenth is out of step after five periods, a window's length: fits find only the nearest place.
STIFFNESSES = (1.0, 0.6, 1.7, 0.35, 0.45, 0.8, 1.3, 2.3, 3.0, 4.0, 5.6)

SHAPES: dict[str, Shape] = {
    "coulomb_friction": Shape(FORCE, (_up("friction", lambda s: 0.03 * s.force, 30, (1.0, 0.2)),), {}),
    "stiction": Shape(
        FORCE,
        (
            _up("excess", lambda s: 0.02 * s.force, 30),
            Freedom("velocity", lambda s: s.slow, lambda s: 0.1 * s.slow, lambda s: 30 * s.slow, (1.0, 4.0)),
        ),
        {},
    ),
    "viscous_friction": Shape(FORCE, (_up("coefficient", _damping, 100),), {}),
    "asymmetric_friction": Shape(
        FORCE, (_both("friction_difference", lambda s: 0.01 * s.force, 30), _both("coefficient_difference", _damping, 30)), {}
    ),
    "pressure_friction": Shape(FORCE, (_up("coefficient", lambda s: 0.03 * s.area, 20),), {}),
    "backlash": Shape(
        FORCE,
        (
            _up("gap", lambda s: 0.001 * s.length, 50, (1.0, 4.0)),
            Freedom("stiffness", lambda s: 0.5 * s.stiffness, lambda s: 0.02 * s.stiffness, lambda s: 10 * s.stiffness),
            Freedom("actuator_mass", lambda s: 0.15 * s.mass, lambda s: 0.01 * s.mass, lambda s: 0.9 * s.mass),
        ),
        {"damping": lambda s: 0.02 * (s.stiffness * s.mass) ** 0.5},
    ),
    "inertia_error": Shape(FORCE, (Freedom("extra", lambda s: 0.05 * s.mass, lambda s: -0.6 * s.mass, lambda s: 3 * s.mass),), {}),
    "gravity": Shape(FORCE, (_both("tilt_rad", lambda s: 0.01, 50),), {}),
    "valve_deadband": Shape(VALVE, (_up("overlap", lambda s: 0.01, 70, (0.3, 2.0)),), {}),
    "valve_hysteresis": Shape(VALVE, (_up("half_width", lambda s: 0.005, 30, (0.4, 3.0)),), {}),
    "valve_null_bias": Shape(VALVE, (_both("bias", lambda s: 0.005, 60),), {}),
    "valve_saturation": Shape(VALVE, (Freedom("opening", lambda s: -0.1, lambda s: 0.02, lambda s: 1.0, (2.0, 5.0, 7.0)),), {}),
    "valve_lag": Shape(
        VALVE,
        (
            Freedom("time_constant_s", lambda s: 0.003, lambda s: 0.0005, lambda s: 0.15, (1.0, 4.0)),
            Freedom("damping_ratio", lambda s: 0.2, lambda s: 0.2, lambda s: 2.0, (4.0,)),
        ),
        {},
    ),
    "valve_flow_asymmetry": Shape(VALVE, (_both("difference", lambda s: 0.03, 40),), {}),
    "transport_delay": Shape(VALVE, (_up("delay_s", lambda s: 0.002, 45, (1.0, 5.0)),), {}),
    "cross_leakage": Shape(FLOW, (_up("conductance_m3_per_s_Pa", _leak, 200, (1.0, 0.1)),), {}),
    "external_leakage": Shape(FLOW, (_up("conductance_m3_per_s_Pa", _leak, 200, (1.0, 0.1)),), {}),
    "bulk_modulus_temperature": Shape(FLOW, (_both("temperature_slope", lambda s: 0.0035, 5),), {}),
    "entrained_air": Shape(FLOW, (_up("fraction", lambda s: 0.005, 20, (1.0, 0.2)),), {}),
    "hose_compliance": Shape(FLOW, (_up("compliance_m3_per_m3_Pa", lambda s: 3e-10, 100, (1.0, 4.0)),), {}),
    "supply_droop": Shape(SUPPLY, (_up("inverse_gas_volume", lambda s: 433.0, 50, (1.0, 0.2)),), {"pump_flow_m3_per_s": lambda s: 6.3e-4}),
    "return_back_pressure": Shape(
        SUPPLY,
        (_up("pressure_Pa", lambda s: 0.01 * s.pressure, 20), _up("resistance_Pa_s2_per_m6", lambda s: 0.01 * s.pressure / 4e-7, 100)),
        {},
    ),
    "line_loss": Shape(SUPPLY, (_up("resistance_Pa_s2_per_m6", lambda s: 0.01 * s.pressure / 4e-7, 100),), {}),
    "link_flexibility": Shape(
        LINK,
        (
            Freedom("bending_stiffness_N_m2", lambda s: s.bending, lambda s: 0.05 * s.bending, lambda s: 20 * s.bending, STIFFNESSES),
            Freedom("damping_ratio", lambda s: 0.005, lambda s: 0.0005, lambda s: 0.1, (1.0,)),
        ),
        {},
    ),
    "payload_error": Shape(
        LINK, (Freedom("extra_kg", lambda s: 0.05 * s.payload, lambda s: -0.9 * s.payload, lambda s: 5 * s.payload),), {}
    ),
    "link_damping_error": Shape(LINK, (Freedom("extra", lambda s: 0.005, lambda s: -0.005, lambda s: 0.1),), {}),
    "sensor_delay": Shape(SENSOR, (_up("delay_s", lambda s: 0.002, 50, (1.0, 5.0)),), {}),
    "sensor_scale": Shape(SENSOR, (Freedom("factor", lambda s: 0.01, lambda s: 0.3, lambda s: 3.0, (1.0, -1.0)),), {}),
    "sensor_offset": Shape(SENSOR, (_both("offset", lambda s: max(3 * s.noise, 0.001 * s.span), 300),), {}),
    "sensor_polarity": Shape(SENSOR, (), {"sign": lambda s: -1.0}),
    "sensor_quantization": Shape(SENSOR, (_up("step", lambda s: 8 * s.noise, 100, (1.0, 5.0)),), {}),
}
