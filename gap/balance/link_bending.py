"""The bending of the link, the first shape of (P25) of docs/method/plant.md, over the supports of a log."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from config.schema.effect import Hook
from gap.balance.log_signals import Inertia, LogSignals, mass_matrix, rate
from gap.balance.weak_form import Bump, Sum, supports
from gap.data.measured import Array
from sim_backend.memory.layout import C
from sim_backend.physics.laws import LAWS
from sim_backend.physics.link import K11, damping_factor, shape_forces


def link_bending(log: LogSignals, where: str, test: Bump, starts: NDArray[np.int64]) -> tuple[Sum, Array]:
    """Inertia of the tip + elastic and damping force + own laws of effects = 0 in the first shape; of a rigid link: deflection = 0."""
    rows, p, noise = test.rows, log.p, log.sigma["tip.deflection"]
    done, always = Sum(len(starts)), np.ones(len(starts), dtype=bool)
    tip, length = supports(log.signals["tip.deflection"], starts, rows), log.signals["prismatic.position"][starts + rows // 2]
    if p[C.BENDING_STIFFNESS] == 0.0:
        done.add(-1.0, test.value, tip, noise)
        return done, always
    m = mass_matrix(log, starts, rows)
    names = {Inertia.TURN_BEND_1: "rotary.position", Inertia.EXTEND_BEND_1: "prismatic.position", Inertia.BEND_1: "tip.deflection"}
    for column, name in names.items():
        done.add(-m[:, column], test.acceleration, supports(log.signals[name], starts, rows), log.sigma[name])
    stiffness = p[C.BENDING_STIFFNESS] * K11 / length**3
    done.add(-stiffness, test.value, tip, noise)
    damping = np.array([damping_factor(value, p) for value in length]) * K11
    done.add(-damping, test.rate, tip, noise)
    if Hook.BENDING in LAWS:
        done.add(1.0, test.value, supports(_lawful(log), starts, rows))
    middle = log.signals["tip.deflection"][starts + rows // 2]
    done.total = done.total - (m[:, Inertia.BEND_1_BIAS] - stiffness * middle)  # the bias without its elastic force
    return done, always


def _lawful(log: LogSignals) -> Array:
    """The force of the effects' own laws on the deflection at every row, N."""
    p, tip, length = log.p, log.signals["tip.deflection"], log.signals["prismatic.position"]
    tip_d = rate(tip, log.period_s)
    elastic = p[C.BENDING_STIFFNESS] * K11 / length**3 * tip
    factor = np.array([damping_factor(value, p) for value in length])
    whole = [shape_forces(length[k], tip[k], tip_d[k], 0.0, elastic[k], 0.0, factor[k], p)[0] for k in range(len(tip))]
    force: Array = np.array(whole) + elastic + factor * K11 * tip_d
    return force
