"""A small valid rig file for the tests, and a way to change one line of it."""

from __future__ import annotations

SMALL = """\
longreach: rig/1
name: bench
arm:
  kind: single_axis
loop:
  rate: 500 Hz
  overruns: {window: 2 s}
joints:
  axis:
    motion: linear
    travel: [0 in, 48 in]
    rate_limit: 10 in/s
    acceleration_limit: 100 in/s^2
    following_error_limit: 0.5 in
servo:
  axis:
    gain: 8 V/in
devices:
  plant: {driver: sim}
signals:
  axis.position:
    device: plant
    channel: axis.position
    calibration: {scale: 25 um}
    low: -1 in
    high: 49 in
  axis.supply_pressure:
    device: plant
    channel: axis.supply_pressure
    high: 3000 psi
outputs:
  axis: {device: plant, channel: axis.command}
interlocks:
  supply_pressure_min: 1500 psi
"""


def changed(*replacements: tuple[str, str]) -> str:
    """SMALL with each (old, new) replaced; old must stand in it exactly once."""
    text = SMALL
    for old, new in replacements:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in the small rig"
        text = text.replace(old, new)
    return text
