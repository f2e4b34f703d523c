"""The link's first mode while the joints move: one period of the loop, exact for a constant frequency.

The static shape alone in the equations of the sliding link, (P22) to (P25) of docs/method/plant.md.
With w the tip's deflection and v = ẇ + α θ̇ the joint's acceleration is not needed:

    ẇ = v − α θ̇,   v̇ = −ω² w − 2ζω (v − α θ̇) − L̇ θ̇,   α = (M L + 11/40 m L²)/(M + 33/140 m L), which is L for a heavy payload
"""

from __future__ import annotations

from math import cos, sin

from config.schema.rig import LinkMode


def carried_arm(link: LinkMode, extension_m: float) -> float:
    """α in m: how much tip motion one radian of the joint asks of the mode."""
    line = link.mass_per_length_kg_per_m * extension_m
    return extension_m * (link.payload_kg + 11.0 / 40.0 * line) / (link.payload_kg + 33.0 / 140.0 * line)


def one_period(state: tuple[float, float], omega: float, drag: float, carried: float, swept: float, period_s: float) -> tuple[float, float]:
    """(w, v) one period later, in m and m/s. `drag` = 2ζω, `carried` = α θ̇ (m/s), `swept` = L̇ θ̇ (m/s²)."""
    w, v = state
    c, s = cos(omega * period_s), sin(omega * period_s)
    speed = v - carried
    return c * w + s / omega * speed, carried + (1.0 - drag * period_s) * (-omega * s * w + c * speed) - period_s * swept
