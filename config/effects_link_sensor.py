"""Entries of `plant.effects` at the link and at a sensor."""

from __future__ import annotations

from typing import Literal

from config.effect_entry import LinkEntry, SensorEntry, quantity_by_place
from config.section import quantity

SIGNAL_UNITS = {"angle": "rad", "length": "m", "pressure": "Pa", "temperature": "K", "acceleration": "m/s^2"}


class LinkFlexibility(LinkEntry):
    effect: Literal["link_flexibility"]
    bending_stiffness_N_m2: float = quantity("N*m^2", "EI of the link; 0 stands for a rigid link", low=0, high=1e8)
    damping_ratio: float = quantity("", "structural damping ratio of the first mode", 0.005, low=0, high=0.5)


class PayloadError(LinkEntry):
    effect: Literal["payload_error"]
    extra_kg: float = quantity("kg", "payload beyond the plant's own", low=-500, high=1000)


class LinkDampingError(LinkEntry):
    effect: Literal["link_damping_error"]
    extra: float = quantity("", "structural damping ratio beyond that of link_flexibility", low=-0.2, high=0.5)


class SensorDelay(SensorEntry):
    effect: Literal["sensor_delay"]
    delay_s: float = quantity("s", "the signal arrives this much later", low=0, high=0.1)


class SensorScale(SensorEntry):
    effect: Literal["sensor_scale"]
    factor: float = quantity("", "reading per true value", low=0.01, high=100)


class SensorOffset(SensorEntry):
    effect: Literal["sensor_offset"]
    offset: float = quantity_by_place(SIGNAL_UNITS, "reading at the true value 0", low=-1e9, high=1e9)


class SensorPolarity(SensorEntry):
    effect: Literal["sensor_polarity"]
    sign: Literal[-1, 1]


class SensorQuantization(SensorEntry):
    effect: Literal["sensor_quantization"]
    step: float = quantity_by_place(SIGNAL_UNITS, "the reading moves in steps of this size", low=0, high=1e9)


LINK_EFFECTS = (LinkFlexibility, PayloadError, LinkDampingError)
SENSOR_EFFECTS = (SensorDelay, SensorScale, SensorOffset, SensorPolarity, SensorQuantization)
