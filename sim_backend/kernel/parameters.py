"""Rig file → the kernel's flat parameter vector: first the ideal plant, then every effect writes its entries."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from config.errors import PlantError
from config.schema.effect_entry import EffectEntry
from config.schema.effect_library import EFFECTS
from config.schema.plant import Plant
from config.schema.plant_joint import Crosshead, Cylinder, ForceActuator, PlantJoint, RotaryActuator, TorqueActuator, Turntable, Valve
from config.schema.plant_sensor import Sensor
from config.schema.rig import Rig
from sim_backend.memory.layout import J_START, J_STRIDE, S_START, S_STRIDE, C, J, Kind, S, TrueSignal, parameter_names
from sim_backend.physics.chambers import ATMOSPHERE_PA
from sim_backend.physics.laws import BLOCKS, END, block_names

_ROTARY_SLOT, _LINEAR_SLOT = 0, 1
_UNLIMITED = 1e9  # slew rate of a drive that follows at once, 1/s
_SIGNAL_OF_JOINT = {
    "position": TrueSignal.POSITION,
    "second_position": TrueSignal.SECOND_POSITION,
    "supply_pressure": TrueSignal.SUPPLY_PRESSURE,
    "return_pressure": TrueSignal.RETURN_PRESSURE,
    "supply_temperature": TrueSignal.SUPPLY_TEMPERATURE,
    "return_temperature": TrueSignal.RETURN_TEMPERATURE,
    "pressure_a": TrueSignal.PRESSURE_A,
    "pressure_b": TrueSignal.PRESSURE_B,
}
_SIGNAL_OF_RIG = {
    "tip.acceleration": TrueSignal.TIP_ACCELERATION,
    "tip.deflection": TrueSignal.TIP_DEFLECTION,
    "reservoir_temperature": TrueSignal.RESERVOIR_TEMPERATURE,
}


class Parameters:
    """The parameter vector of one rig, and where its joints and sensors stand in it.

    `values`: float64, length laws.END, SI units (degC for temperatures); `names` says what each entry is.
    """

    def __init__(self, rig: Rig) -> None:
        plant = _plant_of(rig)
        self.values: NDArray[np.float64] = np.zeros(END)
        self.names = (*parameter_names(), *block_names())
        self.slots = {name: _ROTARY_SLOT if plant.joints[name].motion == "rotary" else _LINEAR_SLOT for name in rig.joints}
        self.sensors = {name: number for number, name in enumerate(plant.sensors)}
        self._write_plant(plant, rig)
        for name, joint in plant.joints.items():
            self._write_joint(self.offset(J.KIND, name), joint)
        for name, sensor in plant.sensors.items():
            self._write_sensor(self.offset(S.SIGNAL, f"sensor:{name}"), name, sensor)
        for added in (False, True):  # what is added comes after what is set, in whatever order the file has them
            for entry in plant.effects:
                self._write_effect(entry, added)

    def offset(self, index: IntEnum, where: str) -> int:
        """Position in the vector of an entry of the whole plant, of a joint or of a `sensor:SIGNAL`."""
        if isinstance(index, J):
            return J_START + self.slots[where] * J_STRIDE + index
        if isinstance(index, S):
            return S_START + self.sensors[where.removeprefix("sensor:")] * S_STRIDE + index
        return int(index)

    def _write_effect(self, entry: EffectEntry, added: bool) -> None:
        """Write the entries of an effect that are added to others, or those that are not; and the numbers of its own law."""
        given, effect = entry.model_dump(by_alias=True), EFFECTS[entry.effect]
        if effect.law:
            place = self.slots.get(entry.where, self.sensors.get(entry.where.removeprefix("sensor:"), 0))  # 0: supply and link
            at = BLOCKS[effect.name].start + place * BLOCKS[effect.name].width
            present = float(not effect.is_neutral(entry))
            self.values[at : at + 1 + len(effect.law.parameters)] = [present, *(given[key] for key in effect.law.parameters)]
        for write in (each for each in effect.writes if each.added is added):
            at = self.offset(write.index, entry.where)
            value = np.atleast_1d(write.convert(given[write.parameter]))
            part = slice(at, at + value.size)
            self.values[part] = self.values[part] + value if write.added else value

    def _write_plant(self, plant: Plant, rig: Rig) -> None:
        self._put(C.STEP, plant.step_s)
        self._put(C.HUB_OFFSET, rig.arm.hub_offset_m)
        self._put(C.PUMP_BAND, 1.0)
        self._put(C.PUMP_LAG, 1.0)
        if plant.oil:
            self._write_oil(plant)
        if plant.supply:
            self._put(C.SUPPLY_PRESSURE, plant.supply.pressure_Pa)
            self._put(C.RETURN_PRESSURE, plant.supply.return_pressure_Pa)
        if plant.thermal:
            self._write_thermal(plant)
        if rig.arm.kind == "rotary_prismatic":
            self._write_link(plant)

    def _write_oil(self, plant: Plant) -> None:
        oil = plant.oil
        assert oil is not None
        self._put(C.DENSITY, oil.density_kg_per_m3)
        self._put(C.SPECIFIC_HEAT, oil.specific_heat_J_per_kg_K)
        self._put(C.BULK_MODULUS, oil.bulk_modulus_Pa)
        self._put(C.BULK_PRESSURE_SLOPE, oil.bulk_modulus_pressure_slope)
        self._put(C.VAPOUR_PRESSURE, oil.vapour_pressure_Pa - ATMOSPHERE_PA)
        self._put(C.WALTHER_A, oil.walther_a)
        self._put(C.WALTHER_B, oil.walther_b)
        self._put(C.INITIAL_TEMPERATURE, oil.initial_temperature_C)

    def _write_thermal(self, plant: Plant) -> None:
        heat = plant.thermal
        assert heat is not None
        self._put(C.THERMAL, 1.0)
        self._put(C.AMBIENT, heat.ambient_C)
        self._put(C.RESERVOIR_CAPACITY, heat.reservoir_capacity_J_per_K)
        self._put(C.RESERVOIR_LOSS, heat.reservoir_loss_W_per_K)
        self._put(C.HOSE_CAPACITY, heat.hose_capacity_J_per_K)
        self._put(C.HOSE_INSIDE, heat.hose_inside_W_per_K)
        self._put(C.HOSE_OUTSIDE, heat.hose_outside_W_per_K)
        self._put(C.METAL_CAPACITY, heat.metal_capacity_J_per_K)
        self._put(C.METAL_INSIDE, heat.metal_inside_W_per_K)
        self._put(C.METAL_OUTSIDE, heat.metal_outside_W_per_K)
        self._put(C.METAL_SHARE, heat.metal_share)
        self._put(C.THERMAL_PUMP_FLOW, heat.pump_flow_m3_per_s)
        self._put(C.BYPASS_SHARE, heat.bypass_share)
        self._put(C.PUMP_LOSS, heat.pump_loss_W)

    def _write_link(self, plant: Plant) -> None:
        link = plant.link
        assert link is not None
        self._put(C.ARM, 1.0)
        self._put(C.HUB_INERTIA, link.hub_inertia_kg_m2)
        self._put(C.MASS_PER_LENGTH, link.mass_per_length_kg_per_m)
        self._put(C.TUBE_LENGTH, link.total_length_m)
        self._put(C.CARRIAGE, link.carriage_kg)
        self._put(C.PAYLOAD, link.payload_kg)
        self._put(C.PAYLOAD_INERTIA, link.payload_inertia_kg_m2)

    def _write_joint(self, at: int, joint: PlantJoint) -> None:
        values = self.values
        values[at + J.LOW], values[at + J.HIGH] = joint.travel
        values[at + J.INITIAL] = joint.initial
        values[at + J.STOP_STIFFNESS] = joint.stop_stiffness
        values[at + J.STOP_LOSS] = joint.stop_restitution_loss
        values[at + J.BRISTLE_STIFFNESS] = joint.bristle_stiffness
        values[at + J.BRISTLE_DAMPING] = joint.bristle_damping
        values[at + J.BRISTLE_FADE] = joint.bristle_fade
        values[at + J.STRIBECK] = joint.bristle_fade
        values[at + J.SATURATION] = 1.0
        values[at + J.VALVE_DAMPING] = 1.0
        if isinstance(joint, (RotaryActuator, Cylinder)):
            self._write_actuator(at, joint)
            self._write_valve(at, joint.valve)
        elif isinstance(joint, (ForceActuator, TorqueActuator)):
            gain, mass = _gain_and_mass(joint)
            values[at + J.KIND] = Kind.FORCE
            values[at + J.MASS] = mass
            values[at + J.FULL_SCALE] = joint.full_scale_V
            values[at + J.FORCE_GAIN] = gain * joint.full_scale_V
            values[at + J.SLEW_RATE] = _UNLIMITED
        elif isinstance(joint, (Crosshead, Turntable)):
            self._write_imposed(at, joint)

    def _write_imposed(self, at: int, joint: Crosshead | Turntable) -> None:
        values = self.values
        values[at + J.KIND] = Kind.IMPOSED
        values[at + J.FULL_SCALE] = 1.0
        if isinstance(joint, Crosshead):
            values[at + J.AREA_A], values[at + J.MASS] = joint.area_m2, joint.mass_kg
            values[at + J.FULL_SCALE] = joint.full_scale_V
            values[at + J.FORCE_GAIN] = joint.gain_N_per_V * joint.full_scale_V
            values[at + J.SLEW_RATE] = _UNLIMITED

    def _write_actuator(self, at: int, joint: RotaryActuator | Cylinder) -> None:
        values = self.values
        values[at + J.KIND] = Kind.HYDRAULIC
        if isinstance(joint, RotaryActuator):
            values[at + J.AREA_A] = values[at + J.AREA_B] = joint.displacement_m3_per_rad
            values[at + J.VOLUME_A], values[at + J.VOLUME_B] = joint.volume_a_m3, joint.volume_b_m3
            values[at + J.MASS] = joint.inertia_kg_m2
            return
        bore, rod = joint.bore_m, joint.rod_m
        values[at + J.AREA_A] = math.pi / 4 * bore**2
        values[at + J.AREA_B] = math.pi / 4 * (bore**2 - rod**2)
        low, high = joint.travel
        values[at + J.VOLUME_POSITION] = low
        values[at + J.VOLUME_A] = joint.dead_volume_a_m3
        values[at + J.VOLUME_B] = joint.dead_volume_b_m3 + values[at + J.AREA_B] * (high - low)
        values[at + J.MASS] = joint.mass_kg

    def _write_valve(self, at: int, valve: Valve) -> None:
        values = self.values
        values[at + J.FLOW_COEFFICIENT] = valve.rated_flow_m3_per_s / math.sqrt(valve.rated_pressure_drop_Pa / 2)
        values[at + J.FULL_SCALE] = valve.full_scale_V
        values[at + J.SLEW_RATE] = 1 / valve.stroke_time_s
        values[at + J.ROUNDING] = valve.null_rounding
        values[at + J.NULL_ADJUSTMENT] = valve.null_adjustment
        values[at + J.LAMINAR_PRESSURE] = valve.laminar_pressure_Pa

    def _write_sensor(self, at: int, name: str, sensor: Sensor) -> None:
        values = self.values
        values[at + S.SIGNAL] = self.signal(name)
        values[at + S.RESOLUTION] = sensor.resolution
        values[at + S.NOISE] = sensor.noise
        values[at + S.BANDWIDTH] = sensor.bandwidth_Hz
        values[at + S.BIAS] = sensor.bias
        values[at + S.LOW], values[at + S.HIGH] = sensor.low, sensor.high
        values[at + S.DROPOUT] = sensor.dropout
        values[at + S.SCALE] = values[at + S.POLARITY] = 1.0
        self._put(C.SENSORS, float(len(self.sensors)))

    def signal(self, name: str) -> int:
        """Index of a signal's true value in the kernel's signal vector."""
        if name in _SIGNAL_OF_RIG:
            return int(_SIGNAL_OF_RIG[name])
        joint, quantity = name.split(".")
        return int(_SIGNAL_OF_JOINT[quantity]) + self.slots[joint]

    def _put(self, index: C, value: float) -> None:
        self.values[index] = value


def _gain_and_mass(joint: ForceActuator | TorqueActuator) -> tuple[float, float]:
    if isinstance(joint, ForceActuator):
        return joint.gain_N_per_V, joint.mass_kg
    return joint.gain_N_m_per_V, joint.inertia_kg_m2


def _plant_of(rig: Rig) -> Plant:
    """The plant section, checked against the rest of the rig."""
    plant = rig.plant
    if plant is None:
        raise PlantError("the rig has no section 'plant'", where=rig.name, next_step="The simulated backend needs one.")
    if set(plant.joints) != set(rig.joints):
        raise PlantError(
            "plant.joints must be the rig's joints", value=", ".join(plant.joints), limit=", ".join(rig.joints), where=rig.name
        )
    for name, joint in plant.joints.items():
        if joint.motion != rig.joints[name].motion:
            raise PlantError(f"plant.joints.{name} does not move as the joint does", value=joint.motion, limit=rig.joints[name].motion)
        if joint.is_hydraulic and not (plant.oil and plant.supply):
            raise PlantError(f"plant.joints.{name} is hydraulic", where=rig.name, next_step="Add plant.oil and plant.supply.")
    if rig.arm.kind == "rotary_prismatic" and plant.link is None:
        raise PlantError("a rotary_prismatic arm needs plant.link", where=rig.name)
    missing = [name for name in plant.joints if f"{name}.position" not in plant.sensors]
    if missing:
        raise PlantError("plant.sensors has no position of a joint", value=", ".join(missing), next_step="Add sensors for J.position.")
    return plant
