"""The effects that may be missing: what is free in each, its plausible range on this rig, and where a fit starts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from config.effect_entry import EffectEntry, unit_at
from config.plant import EFFECT_SECTIONS, Plant, effect_name
from config.plant_joint import Crosshead, Cylinder, RotaryActuator
from config.rig import Rig
from config.section import yaml_key
from config.signals import signal_measures
from gap.model import Free
from sim_backend.effects.registry import REGISTRY

GRAVITY_M_PER_S2 = 9.80665
HELD_PRESSURE_PA = 1e6  # yardstick of a rod pressed into a held chamber
RUBBING = ("coulomb_friction", "stiction", "viscous_friction", "asymmetric_friction", "pressure_friction", "inertia_error")


@dataclass(frozen=True, slots=True)
class Sizes:
    """What is large for one place of this rig, in SI: the yardsticks of plausible effects."""

    force: float = 1.0  # of the actuator at full supply pressure or full command
    velocity: float = 1.0  # the joint's rate limit
    mass: float = 1.0
    length: float = 1.0  # 1 m, or 1 rad
    area: float = 1.0
    pressure: float = 1e7
    slow: float = 0.01  # velocity at which friction's micro-damping has faded
    stiffness: float = 1.0
    payload: float = 10.0
    bending: float = 1000.0
    noise: float = 1e-6  # of the sensor
    span: float = 1.0  # of the sensor's range


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


@dataclass(frozen=True, slots=True)
class Candidate:
    """One effect at one place. `entry` is neutral; `starts` are values of `free` from which to fit."""

    effect: str
    where: str
    equation: str
    entry: EffectEntry
    free: tuple[Free, ...]
    starts: tuple[tuple[float, ...], ...]

    @property
    def label(self) -> str:
        return f"{self.effect} at {self.where}"


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
        (_up("gap", lambda s: 0.001 * s.length, 50, (1.0, 4.0)),),
        {
            "stiffness": lambda s: 0.5 * s.stiffness,
            "actuator_mass": lambda s: 0.15 * s.mass,
            "damping": lambda s: 0.02 * (s.stiffness * s.mass) ** 0.5,
        },
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
            Freedom("bending_stiffness_N_m2", lambda s: s.bending, lambda s: 0.05 * s.bending, lambda s: 20 * s.bending, (1.0, 0.6, 1.7)),
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

# A difference between the directions needs something to differ: without it, it would be one-sided friction, which no seal has.
_EXCEEDS = {"stiction": "coulomb_friction"}  # breakaway beyond the friction while sliding needs a friction while sliding
_NEEDS = {"friction_difference": "coulomb_friction", "coefficient_difference": "viscous_friction"}


def candidates(rig: Rig, channels: frozenset[str]) -> list[Candidate]:
    """Every effect at every place of the rig that its file does not have yet; sensor effects only for the channels compared."""
    plant = rig.plant
    assert plant is not None
    present = {(entry.effect, entry.where) for entry in plant.effects}
    found = []
    for section in EFFECT_SECTIONS:
        name = effect_name(section)
        for where, kind in _places(section, plant, rig, channels):
            possible = name not in _EXCEEDS or (_EXCEEDS[name], where) in present
            if possible and (name, where) not in present:
                beside = frozenset(effect for effect, place in present if place == where)
                found.append(_candidate(name, where, kind, section, _sizes(rig, plant, where), beside))
    return [candidate for candidate in found if candidate.free or candidate.effect == "sensor_polarity"]


def _candidate(name: str, where: str, kind: str, section: type[EffectEntry], sizes: Sizes, beside: frozenset[str]) -> Candidate:
    shape = SHAPES[name]
    given: dict[str, object] = {"effect": name, "where": where, "quantity_kind": kind}
    given |= {yaml_key(key): value(sizes) for key, value in shape.fixed.items()}
    neutral = REGISTRY[name].neutral
    free, starts = [], []
    for freedom in shape.free:
        if _NEEDS.get(freedom.parameter, "") not in ("", *beside):
            continue
        key, field = yaml_key(freedom.parameter), section.model_fields[freedom.parameter]
        typical, calm = freedom.typical(sizes), neutral.get(key, 0.0)
        values = tuple(calm + share * typical for share in freedom.starts)
        rest = neutral[key] if key in neutral else values[0]
        given[key] = rest
        unit = unit_at(field, kind) or ""
        free.append(Free((freedom.parameter,), key, unit, rest, abs(typical), freedom.low(sizes), freedom.high(sizes), False))
        starts.append(values)
    if name == "sensor_polarity":
        given["sign"] = -1
    return Candidate(name, where, shape.equation, section.model_validate(given), tuple(free), _combined(starts))


def _combined(starts: Sequence[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Starting points: every start of the parameter with most of them, the others at their first; asymmetric pairs also crossed."""
    if not starts:
        return ((),)
    longest = max(range(len(starts)), key=lambda k: len(starts[k]))
    return tuple(tuple(value if k == longest else other[0] for k, other in enumerate(starts)) for value in starts[longest])


def _places(section: type[EffectEntry], plant: Plant, rig: Rig, channels: frozenset[str]) -> Iterator[tuple[str, str]]:
    """Where this effect can be, with what the place measures (which decides units)."""
    motions = {name: joint.motion for name, joint in plant.joints.items()}
    for where, kind in [*motions.items(), ("supply", ""), ("link", "")]:
        if _allowed(section, plant, rig, where):
            yield where, kind
    kinds = signal_measures(motions)
    name = effect_name(section)
    for signal in plant.sensors if name.startswith("sensor_") else ():
        if signal in channels and not (name == "sensor_offset" and signal.endswith("supply_pressure")):
            yield f"sensor:{signal}", kinds[signal]


def _allowed(section: type[EffectEntry], plant: Plant, rig: Rig, where: str) -> bool:
    name = effect_name(section)
    if name.startswith("sensor_"):
        return False
    equation = SHAPES[name].equation
    if where == "supply":
        return equation == SUPPLY and plant.supply is not None
    if where == "link":
        arm = rig.arm.kind == "rotary_prismatic"
        return equation == LINK and arm and (name != "link_damping_error" or any(e.effect == "link_flexibility" for e in plant.effects))
    if equation in (SUPPLY, LINK):
        return False
    joint = plant.joints[where]
    if isinstance(joint, Crosshead):
        return joint.area_m2 > 0 and name in RUBBING
    if joint.is_imposed:
        return False
    if name == "gravity":
        return where == next(iter(plant.joints))  # one entry tilts the whole arm
    return joint.is_hydraulic or (equation != FLOW and name not in ("pressure_friction", "valve_flow_asymmetry"))


def _sizes(rig: Rig, plant: Plant, where: str) -> Sizes:
    pressure = plant.supply.pressure_Pa if plant.supply else 1e7
    if where.startswith("sensor:"):
        sensor = plant.sensors[where.removeprefix("sensor:")]
        return Sizes(noise=max(sensor.noise, sensor.resolution / 3), span=sensor.high - sensor.low)
    if where in ("supply", "link"):
        payload = plant.link.payload_kg if plant.link else 0.0
        bending = rig.link_mode.bending_stiffness_N_m2 if rig.link_mode else 3000.0
        return Sizes(pressure=pressure, payload=max(payload, 2.0), bending=bending)
    joint, limits = plant.joints[where], rig.joints[where]
    area, force = _drive(joint, pressure)
    return Sizes(
        force=force, velocity=limits.rate_limit, mass=_mass(plant, where), area=area, pressure=pressure, slow=joint.bristle_fade,
        stiffness=joint.bristle_stiffness,
    )  # fmt: skip


def _drive(joint: object, pressure: float) -> tuple[float, float]:
    """Area and force at full supply pressure, or at full command."""
    if isinstance(joint, RotaryActuator):
        return joint.displacement_m3_per_rad, joint.displacement_m3_per_rad * pressure
    if isinstance(joint, Cylinder):
        area = 0.785 * joint.bore_m**2
        return area, area * pressure
    if isinstance(joint, Crosshead):
        return joint.area_m2, joint.area_m2 * HELD_PRESSURE_PA
    gain = getattr(joint, "gain_N_per_V", None) or getattr(joint, "gain_N_m_per_V", 1.0)
    return 1.0, abs(gain * joint.full_scale_V)  # type: ignore[attr-defined]


def _mass(plant: Plant, where: str) -> float:
    joint = plant.joints[where]
    own = getattr(joint, "mass_kg", 0.0) or getattr(joint, "inertia_kg_m2", 0.0)
    if own or plant.link is None:
        return float(own or 1.0)
    link = plant.link
    if joint.motion == "rotary":
        return link.hub_inertia_kg_m2 + link.payload_kg
    return link.carriage_kg + link.payload_kg + link.mass_per_length_kg_per_m * link.total_length_m
