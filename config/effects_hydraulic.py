"""Entries of `plant.effects` at a joint's valve and actuator, and at the supply."""

from __future__ import annotations

from typing import Literal

from config.effect_entry import JointEntry, SupplyEntry
from config.section import quantity


class ValveDeadband(JointEntry):
    effect: Literal["valve_deadband"]
    overlap: float = quantity("", "spool travel either side of the null without flow, share of the full opening", low=0, high=0.9)


class ValveHysteresis(JointEntry):
    effect: Literal["valve_hysteresis"]
    half_width: float = quantity("", "half width of the play between command and spool, share of the full opening", low=0, high=0.2)


class ValveNullBias(JointEntry):
    effect: Literal["valve_null_bias"]
    bias: float = quantity("", "spool opening at command 0 and 40 degC, share of the full opening", low=-0.5, high=0.5)
    temperature_slope: float = quantity("1/K", "null shift per kelvin above 40 degC", 0.0, low=-0.01, high=0.01)


class ValveSaturation(JointEntry):
    effect: Literal["valve_saturation"]
    opening: float = quantity("", "largest opening reached, share of the full opening", low=0.01, high=1)


class ValveLag(JointEntry):
    effect: Literal["valve_lag"]
    time_constant_s: float = quantity("s", "1 / (2 pi f) of the spool's second-order dynamics", low=0, high=0.5)
    damping_ratio: float = quantity("", "damping ratio of the spool", 0.8, low=0.1, high=3)


class ValveFlowAsymmetry(JointEntry):
    effect: Literal["valve_flow_asymmetry"]
    difference: float = quantity("", "flow area for positive minus negative opening, share of their mean", low=-1.5, high=1.5)


class TransportDelay(JointEntry):
    effect: Literal["transport_delay"]
    delay_s: float = quantity("s", "the valve sees its command this much later", low=0, high=0.1)


class CrossLeakage(JointEntry):
    effect: Literal["cross_leakage"]
    conductance_m3_per_s_Pa: float = quantity("m^3/s/Pa", "laminar leakage between the chambers at 40 degC", low=0, high=1e-8)


class ExternalLeakage(JointEntry):
    effect: Literal["external_leakage"]
    conductance_m3_per_s_Pa: float = quantity("m^3/s/Pa", "laminar leakage of each chamber to the outside at 40 degC", low=0, high=1e-8)


class BulkModulusTemperature(JointEntry):
    effect: Literal["bulk_modulus_temperature"]
    temperature_slope: float = quantity("1/K", "relative change of the oil's bulk modulus per kelvin above 40 degC", low=-0.02, high=0.02)
    hose_temperature_slope: float = quantity("1/K", "the same of hoses and structure", 0.0, low=-0.02, high=0.02)


class EntrainedAir(JointEntry):
    effect: Literal["entrained_air"]
    fraction: float = quantity("", "volume of undissolved air at atmospheric pressure over volume of oil", low=0, high=0.2)


class HoseCompliance(JointEntry):
    effect: Literal["hose_compliance"]
    compliance_m3_per_m3_Pa: float = quantity("1/Pa", "relative volume change of hoses and structure per pressure", low=0, high=1e-6)


class SupplyDroop(SupplyEntry):
    effect: Literal["supply_droop"]
    inverse_gas_volume: float = quantity("1/m^3", "1 / gas volume of the accumulator at supply pressure; 0 never droops", low=0, high=1e5)
    pump_flow_m3_per_s: float = quantity("m^3/s", "largest flow of the pressure-compensated pump", low=0, high=0.1)
    regulation_band_Pa: float = quantity(
        "Pa", "pressure below the set one at which the pump gives its largest flow", 689475.7, low=1e3, high=1e7
    )
    pump_lag_s: float = quantity("s", "time constant of the pump's compensator", 0.05, low=0.005, high=2)
    relief_pressure_Pa: float = quantity("Pa", "the relief valve opens", 15168465.0, low=0, high=60e6)
    relief_gain_m3_per_s_Pa: float = quantity("m^3/s/Pa", "relief flow per pressure above that", 2e-9, low=0, high=1e-6)


class ReturnBackPressure(SupplyEntry):
    effect: Literal["return_back_pressure"]
    pressure_Pa: float = quantity("Pa", "return pressure at no flow", low=0, high=5e6)
    resistance_Pa_s2_per_m6: float = quantity("Pa*s^2/m^6", "return pressure per squared flow of each valve", 0.0, low=0, high=1e15)


class LineLoss(SupplyEntry):
    effect: Literal["line_loss"]
    resistance_Pa_s2_per_m6: float = quantity("Pa*s^2/m^6", "pressure lost in the hose to each valve per squared flow", low=0, high=1e15)


VALVE_EFFECTS = (ValveDeadband, ValveHysteresis, ValveNullBias, ValveSaturation, ValveLag, ValveFlowAsymmetry, TransportDelay)
ACTUATOR_EFFECTS = (CrossLeakage, ExternalLeakage, BulkModulusTemperature, EntrainedAir, HoseCompliance)
SUPPLY_EFFECTS = (SupplyDroop, ReturnBackPressure, LineLoss)
