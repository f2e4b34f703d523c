"""Servovalve: command to spool, and spool to chamber flows ((P1) to (P6) of docs/method/plant.md).

Four-land spool: H. E. Merritt, Hydraulic Control Systems, 1967, chapter 5.
"""

from __future__ import annotations

from math import copysign, sqrt

from config.schema.effect import Hook
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import J, Vector
from sim_backend.physics.laws import hooked, slot_of

_told = hooked(Hook.SPOOL_COMMAND)


@compiled
def spool_command(command_V: float, play: float, p: Vector, j: int, temperature_C: float) -> tuple[float, float]:
    """Wanted spool opening (share of full, within the saturation) and the new state of the hysteresis (a play operator)."""
    wanted = command_V / p[j + J.FULL_SCALE] + p[j + J.NULL_ADJUSTMENT] + p[j + J.NULL_BIAS] + p[j + J.NULL_DRIFT] * (temperature_C - 40.0)
    wanted = _told(wanted, (command_V,), slot_of(j), p)
    half = p[j + J.HYSTERESIS]
    play = min(max(play, wanted - half), wanted + half)
    limit = p[j + J.SATURATION]
    return min(max(play, -limit), limit), play


@compiled
def spool_rates(spool: float, rate: float, wanted: float, frequency: float, p: Vector, j: int) -> tuple[float, float]:
    """Derivatives of spool opening and spool rate: second order, with the slew limit. The ends of the stroke: stop_spool."""
    slew = p[j + J.SLEW_RATE]
    acceleration = frequency * (frequency * (wanted - spool) - 2.0 * p[j + J.VALVE_DAMPING] * rate)
    speed = min(max(rate, -slew), slew)
    if (rate >= slew and acceleration > 0.0) or (rate <= -slew and acceleration < 0.0):
        acceleration = 0.0
    return speed, acceleration


@compiled
def stop_spool(x: Vector, spool: int, rate: int) -> None:
    """A spool that has passed the end of its bore in a step stands there, at rest. `spool`, `rate`: their numbers in the state."""
    if abs(x[spool]) > 1.0:
        x[spool], x[rate] = copysign(1.0, x[spool]), 0.0


@compiled
def land_flow(pressure_drop: float, smoothing_squared: float) -> float:
    """Signed square root of a pressure drop with a finite slope at 0, S(Δ) = Δ / (Δ² + δ²)^(1/4)."""
    return pressure_drop / sqrt(sqrt(pressure_drop * pressure_drop + smoothing_squared))


@compiled
def beyond_overlap(spool: float, overlap: float) -> float:
    """What is left of an opening (or of an electric drive's command) outside the dead band ±overlap."""
    return max(spool - overlap, 0.0) + min(spool + overlap, 0.0)


@compiled
def openings(spool: float, p: Vector, j: int) -> tuple[float, float]:
    """Opening of the lands P→A with B→T, and P→B with A→T: overlap, then the rounded null o(x) = (x + sqrt(x² + ε²)) / 2."""
    overlap = p[j + J.OVERLAP]
    if overlap > 0.0:
        spool = beyond_overlap(spool, overlap)
    root = sqrt(spool * spool + p[j + J.ROUNDING] * p[j + J.ROUNDING])
    half = 0.5 * p[j + J.FLOW_ASYMMETRY]
    return (1.0 + half) * 0.5 * (root + spool), (1.0 - half) * 0.5 * (root - spool)
