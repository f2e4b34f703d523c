"""Two valid rig files of one servo cylinder (16/10 mm, 0.2 m): on real devices of every shipped driver, and simulated."""

from __future__ import annotations

_HEAD = """\
longreach: rig/1
name: bench
arm: {kind: single_axis}
loop: {rate: 1 kHz}
joints:
  axis:
    motion: linear
    travel: [0.02 m, 0.18 m]
    rate_limit: 0.2 m/s
    acceleration_limit: 5 m/s^2
    following_error_limit: 20 mm
servo:
  axis:
    gain: 60 V/m
    velocity_feedforward: 8 V*s/m
    velocity_filter: 50 Hz
"""

DEVICES = (
    _HEAD
    + """\
devices:
  encoder:
    driver: canopen_encoder_406
    options:
      bus: {interface: virtual, channel: bench0, bitrate: 1 Mbit/s}
      node: 1
      resolution: 25000
  valve:
    driver: canopen_valve_408
    timeout: 60 ms
    options:
      bus: {interface: virtual, channel: bench0, bitrate: 1 Mbit/s}
      node: 11
      fault_reactions: {89: 2, 75: 2}
  module:
    driver: canopen_io_401
    timeout: 60 ms
    options:
      bus: {interface: virtual, channel: bench0, bitrate: 1 Mbit/s}
      node: 21
      outputs: 1
      inputs: 1
      every_syncs: 4
      loopback: {1: 1}
  gauges:
    driver: modbus
    slow: true
    options:
      transport: tcp
      host: 127.0.0.1
      port: 1502
      channels:
        supply: {address: 0}
        tank: {address: 1, type: uint16}
  thermometer:
    driver: modbus
    slow: true
    options:
      transport: rtu
      port: /dev/ttyUSB0
      unit_id: 3
      parity: none
      channels:
        oil: {table: holding, address: 100, type: float32}
signals:
  axis.position: {device: encoder, channel: position, calibration: {scale: 25 um}, low: -5 mm, high: 210 mm}
  axis.supply_pressure: {device: gauges, channel: supply, calibration: {scale: 1 kPa}, low: -1 MPa, high: 25 MPa, max_age: 0.2 s}
  axis.return_pressure: {device: gauges, channel: tank, calibration: {scale: 100 Pa, offset: -0.5 MPa}, max_age: 0.2 s}
  axis.pressure_a: {device: module, channel: input_1, calibration: {scale: 1 kPa}, low: -1 MPa, high: 25 MPa, max_age: 20 ms}
  reservoir_temperature: {device: thermometer, channel: oil, calibration: {scale: 1 degC}, max_age: 2 s}
outputs:
  axis: {device: valve, channel: spool, scale: 0.1}
interlocks: {supply_pressure_min: 10 MPa, supply_pressure_max: 22 MPa, return_pressure_max: 2 MPa, oil_temperature_max: 60 degC}
"""
)

PLANT = (
    _HEAD
    + """\
devices:
  rig: {driver: sim}
signals:
  axis.position: {device: rig, channel: axis.position, calibration: {scale: 5 um}, low: -5 mm, high: 210 mm}
  axis.supply_pressure: {device: rig, channel: axis.supply_pressure, calibration: {scale: 5 kPa}, low: -1 MPa, high: 25 MPa}
  axis.return_pressure: {device: rig, channel: axis.return_pressure, calibration: {scale: 5 kPa}, low: -1 MPa, high: 25 MPa}
  axis.pressure_a: {device: rig, channel: axis.pressure_a, calibration: {scale: 5 kPa}}
outputs:
  axis: {device: rig, channel: axis.command}
interlocks: {supply_pressure_min: 5 MPa, supply_pressure_max: 15 MPa, return_pressure_max: 1 MPa}
plant:
  joints:
    axis:
      actuator: cylinder
      travel: [0 m, 0.2 m]
      initial: 0.1 m
      bore: 16 mm
      rod: 10 mm
      dead_volume_a: 5 cm^3
      dead_volume_b: 5 cm^3
      mass: 20 kg
      valve: {rated_flow: 5 lpm, rated_pressure_drop: 70 bar, full_scale: 10 V, null_rounding: 0.01}
  oil: {density: 870 kg/m^3, specific_heat: 1900 J/kg/K, bulk_modulus: 1.2 GPa, walther_a: 8.9, walther_b: 3.5}
  supply: {pressure: 10 MPa, return_pressure: 0.1 MPa}
  sensors:
    axis.position: {resolution: 5 um, noise: 5 um, low: -10 mm, high: 220 mm}
    axis.supply_pressure: {resolution: 5 kPa, noise: 20 kPa, low: -1 MPa, high: 25 MPa}
    axis.return_pressure: {resolution: 5 kPa, noise: 20 kPa, low: -1 MPa, high: 25 MPa}
    axis.pressure_a: {resolution: 5 kPa, noise: 20 kPa, low: -1 MPa, high: 25 MPa}
"""
)


def replaced(text: str, old: str, new: str) -> str:
    """The text with `old`, which must stand in it exactly once, replaced."""
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the rig"
    return text.replace(old, new)
