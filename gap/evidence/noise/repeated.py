"""How friction yields before it slides, where that repeats with every reversal: changes of the readings that all windows share.

No real contact is one bristle. A seal that yields in many places is a sum of elements that break away after different ways (Maxwell-slip:
Iwan 1966; Al-Bender, Lampaert and Swevers 2005). Each change here is a share of the friction that acts through other elements than the
model's bristle; the shares are unknown, normal about 0 with one scale for all, which is fitted with the discrepancy.

- On oil a joint's motion is nearly given, whatever rubs: y = y₀ + Σ_k c_k (y(bristle of form k) − y₀).
- On a drive that gives a force, friction decides when the joint moves, and such sums do not hold. There the elements are driven by the
  measured motion, and what they take from the friction acts as a force, small enough that the readings follow it as a straight line. So
  does friction that has another level while the joint is slow. What the noise hides, the last way before it slides, is the model's own
  motion with a contact that springs back instead of creeping: as likely where friction yields at once, so it has a scale of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numba import njit

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.fitting.initial_states import breaking_away
from gap.fitting.simulate import simulate
from sim_backend.memory.layout import J_START, J_STRIDE, SLOTS, J, Kind, Target, Vector

ELASTIC = 0.8
# What an element of another form has, as multiples of the bristle's, and the share of its level up to which it is elastic. It yields over a
# longer or a shorter way, without micro-damping, breaks away at another level, or falls to its sliding level within another velocity. Or it
# springs back without slipping: a sum of bristles creeps, and remembers no turn, however many there are.
FORMS: tuple[tuple[int, float, float], ...] = (
    (J.BRISTLE_STIFFNESS, 0.25, 0.0),
    (J.BRISTLE_STIFFNESS, 0.5, 0.0),
    (J.BRISTLE_STIFFNESS, 2.0, 0.0),
    (J.BRISTLE_STIFFNESS, 4.0, 0.0),
    (J.BRISTLE_DAMPING, 0.0, 0.0),
    (J.STICTION, 2.0, 0.0),
    (J.STRIBECK, 0.5, 0.0),
    (J.STRIBECK, 2.0, 0.0),
    (J.BRISTLE_STIFFNESS, 0.5, ELASTIC),
    (J.BRISTLE_STIFFNESS, 1.0, ELASTIC),
    (J.BRISTLE_STIFFNESS, 2.0, ELASTIC),
    (J.BRISTLE_DAMPING, 0.0, ELASTIC),
)
WAYS, RATIO = 8, 3.0  # of elements on measured motion: how many, and from one to the next the way after which they break away …
FINEST = 0.5  # … the first in standard deviations of the position's noise
SLOW = (0.01, 0.03, 0.1)  # of the motion's root mean square velocity, below which friction may be of another level
_PART = 0.02  # of the friction, for the finite difference


def repeated_changes(experiment: Experiment, p: Vector, readings: Array) -> list[Array]:
    """Changes of the readings with the parameters `p`, each of a share of 1; windows × samples × channels."""
    changes = [moved - readings for moved in simulate(experiment, other_forms(p))]
    for slot in _rubbing(p, Kind.FORCE):
        if np.isfinite(experiment.plan.targets[:, Target.POSITION + slot]).any():
            changes += [(simulate(other, [p])[0] - readings) / _PART for other in _driven(experiment, p, slot)]
    return changes


def elastic_changes(experiment: Experiment, p: Vector, readings: Array) -> list[Array]:
    """The same of contacts that do not creep, joint by joint that a force drives, which break away at the same level after the same way."""
    return [moved - readings for moved in simulate(experiment, [_elastic(p, slot) for slot in _rubbing(p, Kind.FORCE)])]


def _rubbing(p: Vector, kind: Kind) -> list[int]:
    """Joints of one kind with dry friction."""
    starts = [J_START + slot * J_STRIDE for slot in range(SLOTS)]
    return [slot for slot, at in enumerate(starts) if p[at + J.KIND] == kind and breaking_away(p, at) > 0.0]


def _elastic(p: Vector, slot: int) -> Vector:
    other = p.copy()
    other[J_START + slot * J_STRIDE + J.BRISTLE_ELASTIC] = ELASTIC
    return other


def other_forms(p: Vector) -> list[Vector]:
    """Parameters with each hydraulic joint's friction in each of the other forms; none for a joint without dry friction."""
    found = []
    for slot in _rubbing(p, Kind.HYDRAULIC):
        at = J_START + slot * J_STRIDE
        for number, times, elastic in FORMS:
            other = p.copy()
            other[at + number] *= times
            other[at + J.BRISTLE_ELASTIC] = elastic
            found += [other] if np.any(other != p) else []
    return found


def element(position: Array, way: float) -> Array:
    """What one element holds of its share, −1 to 1: a spring that slips after a way (Prandtl's stop operator)."""
    return np.asarray(_stop(position, way))


def _driven(experiment: Experiment, p: Vector, slot: int) -> Iterator[Experiment]:
    """The log with a small part of the friction taken from one element and given to the next, or added while the joint is slow; as volts,
    which are its force."""
    at, plan = J_START + slot * J_STRIDE, experiment.plan
    position = plan.targets[:, Target.POSITION + slot]
    position = np.interp(np.arange(len(position)), np.flatnonzero(np.isfinite(position)), position[np.isfinite(position)])
    step = experiment.velocity_sd[slot] * plan.period_s
    finest = FINEST * max(float(np.std(np.diff(position, n=2))) / np.sqrt(6.0), step)
    held = [element(position, finest * RATIO**k) for k in range(WAYS)]
    volts_per_force = p[at + J.FULL_SCALE] / p[at + J.FORCE_GAIN]
    velocity = np.nan_to_num(plan.targets[:, Target.VELOCITY + slot])
    speed = float(np.sqrt(np.mean(velocity**2)))
    slow = [held[0] * np.exp(-((velocity / (part * speed)) ** 2)) if speed > 0.0 else np.zeros(len(velocity)) for part in SLOW]
    for changed in [*(one - other for one, other in pairwise(held)), *slow]:
        commands = plan.commands_V.copy()
        commands[:, slot] -= _PART * breaking_away(p, at) * volts_per_force * changed
        yield replace(experiment, plan=replace(plan, commands_V=commands))


@njit(cache=True)  # type: ignore[untyped-decorator]
def _stop(position: Array, way: float) -> Array:
    held, out = 0.0, np.empty(len(position))
    for i in range(len(position)):
        moved = position[i] - position[i - 1] if i else 0.0
        held = min(max(held + moved / way, -1.0), 1.0)
        out[i] = held
    return out
