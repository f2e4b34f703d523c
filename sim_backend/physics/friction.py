"""LuGre friction (C. Canudas de Wit and others, IEEE Trans. Automatic Control 40(3), 1995) with micro-damping that fades with velocity.

(P14) to (P16) of docs/method/plant.md, which says why it fades (passivity); stops and drive train: (P18), (P19).
"""

from __future__ import annotations

from math import exp

from config.schema.effect import Hook
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import J, Vector
from sim_backend.physics.laws import hooked, slot_of

_rubbed, _pushed = hooked(Hook.FRICTION), hooked(Hook.FORCE)
FADED = 6.0  # exp(-36) adds nothing to a float64


@compiled
def faded(velocity: float, scale: float) -> float:
    """exp(-(v / scale)²), without the exponential where it is 0 to rounding."""
    ratio = velocity / scale
    return exp(-ratio * ratio) if -FADED < ratio < FADED else 0.0


@compiled
def sliding_level(velocity: float, pressure_difference: float, coulomb: float, fade: float, p: Vector, j: int) -> float:
    """g(v): friction in steady sliding without the viscous part; Coulomb + Stribeck excess + asymmetry + seal pressure.

    `fade`: faded(velocity, BRISTLE_FADE), which is the Stribeck curve too where both have the same scale."""
    level = coulomb + p[j + J.PRESSURE_FRICTION] * abs(pressure_difference)
    if p[j + J.STICTION] > 0.0:
        level += p[j + J.STICTION] * (fade if p[j + J.STRIBECK] == p[j + J.BRISTLE_FADE] else faded(velocity, p[j + J.STRIBECK]))
    if p[j + J.COULOMB_DIFFERENCE] != 0.0:
        level += 0.5 * p[j + J.COULOMB_DIFFERENCE] * (1.0 if velocity > 0.0 else -1.0)
    return float(max(_rubbed(level, (velocity, pressure_difference), slot_of(j), p), 0.0))


@compiled
def slipping(bent: float, elastic: float) -> float:
    """How much of LuGre's slip is left to a contact that does not slip below a share `elastic` of its level, nor while it springs back
    (elasto-plastic: P. Dupont and others, IEEE Trans. Automatic Control 47(5), 2002). `bent`: its force over that level, negative while it
    springs back."""
    if bent <= elastic:
        return 0.0
    return (bent - elastic) / ((1.0 - elastic) * bent) if bent < 1.0 else 1.0


@compiled
def friction(
    velocity: float, bristle: float, pressure_difference: float, coulomb: float, viscous: float, p: Vector, j: int, step_s: float
) -> tuple[float, float]:
    """Friction force (against the velocity) and the rate of the bristle deflection.

    The bristles relax at σ₀|v|/g, faster by 1 / (1 − e) where they are elastic up to a share e of the level; where that is faster than
    the step can follow (2/h) it is held there, which leaves the steady force as it is.
    """
    if p[j + J.VISCOUS_DIFFERENCE] != 0.0:
        viscous += 0.5 * p[j + J.VISCOUS_DIFFERENCE] * (1.0 if velocity > 0.0 else -1.0)
    fade = faded(velocity, p[j + J.BRISTLE_FADE])
    level = sliding_level(velocity, pressure_difference, coulomb, fade, p, j)
    if level == 0.0:
        return viscous * velocity, 0.0
    stiffness = p[j + J.BRISTLE_STIFFNESS]
    relaxation = stiffness * abs(velocity) / level
    elastic = p[j + J.BRISTLE_ELASTIC]
    slip = 1.0 if elastic == 0.0 else slipping(stiffness * (bristle if velocity > 0.0 else -bristle) / level, elastic)
    rate = velocity - slip * relaxation * bristle
    followed = 2.0 * (1.0 - elastic)
    if relaxation * step_s > followed:
        rate *= followed / (relaxation * step_s)
    force = stiffness * bristle + p[j + J.BRISTLE_DAMPING] * fade * rate + viscous * velocity
    return force, rate


@compiled
def stop_force(position: float, velocity: float, p: Vector, j: int) -> float:
    """Force of the mechanical stops, (P19): contact after K. Hunt and F. Crossley (J. Applied Mechanics 42, 1975). It never pulls and never
    gives back more than it took."""
    depth = p[j + J.LOW] - position
    if depth > 0.0:
        return float(p[j + J.STOP_STIFFNESS] * depth * max(1.0 - p[j + J.STOP_LOSS] * velocity, 0.0))
    depth = position - p[j + J.HIGH]
    if depth > 0.0:
        return float(-p[j + J.STOP_STIFFNESS] * depth * max(1.0 + p[j + J.STOP_LOSS] * velocity, 0.0))
    return 0.0


@compiled
def outer_force(force: float, position: float, velocity: float, p: Vector, j: int) -> float:
    """`force` on the load with what the effects' own laws add to it."""
    return _pushed(force, (position, velocity), slot_of(j), p)


@compiled
def drive_force(twist: float, twist_rate: float, p: Vector, j: int) -> float:
    """Force of the drive train on the load: spring and damper beyond half the gap, nothing inside it, never pulls at contact."""
    half = 0.5 * p[j + J.GAP]
    if twist > half:
        return float(max(p[j + J.DRIVE_STIFFNESS] * (twist - half) + p[j + J.DRIVE_DAMPING] * twist_rate, 0.0))
    if twist < -half:
        return float(min(p[j + J.DRIVE_STIFFNESS] * (twist + half) + p[j + J.DRIVE_DAMPING] * twist_rate, 0.0))
    return 0.0
