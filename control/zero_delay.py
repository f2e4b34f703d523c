"""Shaping without delay: the time law of a move is corrected so that the link is at rest when the move ends.

Sought are the spline coefficients c with the least ∫δs̈² for which the link's first mode, driven by the joints over the move with the
extension changing, ends at rest for every frequency of a range around the believed one:

    minimise cᵀQc   subject to   r_k + J_k c = 0,     Q_ij = ∫B̈_i B̈_j,   r_k: what mode k is left with (ω w and ẇ)

c = −Q⁻¹Jᵀ(JQ⁻¹Jᵀ)⁻¹ r, repeated from the corrected path because joints are not linear in s. Plain floats throughout: a plan made again
from its request is the same to the last bit, whatever linear algebra a computer has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, cos, sin
from typing import NamedTuple

from config.rig import LinkMode
from control.corrected_path import SPAN, CorrectedPath, bump
from control.link_mode import LinkFrequency
from control.link_motion import carried_arm, one_period
from control.trajectory import Trapezoid

Joints = Callable[[float], tuple[float, float]]  # path position -> (rotary rad, extension m)
STEP_S = 0.004
KNOTS_A_PERIOD = 4.0
FEWEST_SPLINES, MOST_SPLINES = 8, 80
ROUNDS = 3
RIDGE = 1e-10  # of the largest diagonal element: neighbouring frequencies ask nearly the same


class Sample(NamedTuple):
    """A moment of the move. `slope`: dθ/ds; `rate`: θ̇; `bend`: derivative of θ̇ by s."""

    slope: float
    rate: float
    extension: float
    extension_rate: float
    bend: float


def corrected(path: Trapezoid, joints: Joints, link: LinkMode, scale: float, share: float) -> CorrectedPath:
    """The path that leaves no vibration for frequencies within 1 ± `share` of scale × believed frequency."""
    cycles = path.duration_s * _fastest_Hz(path, joints, LinkFrequency(link, scale))
    points = 2 + ceil(2.0 * share * cycles) if share > 0.0 else 1  # the ends of the range, and as many between as the move can tell apart
    modes = [LinkFrequency(link, scale * (1.0 + share * (2.0 * k / max(points - 1, 1) - 1.0))) for k in range(points)]
    count = min(max(round(KNOTS_A_PERIOD * cycles) - SPAN + 1, FEWEST_SPLINES), MOST_SPLINES)
    metric = _metric(count)
    coefficients = [0.0] * count
    for _ in range(ROUNDS):
        residual, jacobian = _linearised(CorrectedPath(path, coefficients), count, joints, link, modes)
        # about c = 0: the least correction, not the least change of the last one
        wanted = [r - sum([j * c for j, c in zip(row, coefficients, strict=True)]) for r, row in zip(residual, jacobian, strict=True)]
        coefficients = _least(metric, jacobian, [-w for w in wanted])
    return CorrectedPath(path, coefficients)


def _fastest_Hz(path: Trapezoid, joints: Joints, mode: LinkFrequency) -> float:
    """Where the arm is shortest."""
    return mode.frequency_Hz(min(joints(path.distance * k / 20)[1] for k in range(21)))


def _linearised(
    path: CorrectedPath, count: int, joints: Joints, link: LinkMode, modes: Sequence[LinkFrequency]
) -> tuple[list[float], list[list[float]]]:
    """What every mode is left with at the end, and its derivative by the coefficients."""
    steps = max(1, round(path.duration_s / STEP_S))
    step_s = path.duration_s / steps
    samples = [_sample(path, joints, (n + 0.5) * step_s) for n in range(steps)]
    pushes = [_pushes(sample, (n + 0.5) * step_s, path.duration_s / (count + SPAN - 1), count) for n, sample in enumerate(samples)]
    residual, jacobian = [], []
    for mode in modes:
        left, rows = _of_mode(mode, link, samples, pushes, count, step_s)
        residual += left
        jacobian += rows
    return residual, jacobian


def _pushes(sample: Sample, t: float, knot_s: float, count: int) -> list[tuple[int, float]]:
    """Which coefficients change the joint's rate at time t, and by how much: θ̇ = θ'(s) ṡ."""
    newest = int(t / knot_s)
    bumps = [(i, bump(t / knot_s - i)) for i in range(max(0, newest - SPAN + 1), min(newest, count - 1) + 1)]
    return [(i, sample.slope * speed / knot_s + sample.bend * value) for i, (value, speed, _) in bumps]


def _of_mode(
    mode: LinkFrequency, link: LinkMode, samples: list[Sample], pushes: list[list[tuple[int, float]]], count: int, step_s: float
) -> tuple[list[float], list[list[float]]]:
    """(ω w, ẇ) at the end, and both rows of the derivative: the motion forwards, its adjoint backwards."""
    omegas = [mode.omega_d(sample.extension) for sample in samples]
    arms = [carried_arm(link, sample.extension) for sample in samples]
    state = (0.0, 0.0)
    for omega, arm, each in zip(omegas, arms, samples, strict=True):
        drag = 2.0 * mode.damping_ratio * omega
        state = one_period(state, omega, drag, arm * each.rate, each.extension_rate * each.rate, step_s)
    rows = ([0.0] * count, [0.0] * count)
    weights = [(omegas[-1], 0.0), (0.0, 1.0)]  # of (w, v) in what is left; v is ẇ once the joint rests
    for n in range(len(samples) - 1, -1, -1):
        omega = omegas[n]
        c, s = cos(omega * step_s), sin(omega * step_s)
        keep = 1.0 - 2.0 * mode.damping_ratio * omega * step_s
        for k, (a, b) in enumerate(weights):
            # what one unit of joint rate in this step adds, see one_period
            pushed = -arms[n] * (a * s / omega + b * (keep * c - 1.0)) - b * samples[n].extension_rate * step_s
            row = rows[k]
            for i, push in pushes[n]:
                row[i] += pushed * push
            weights[k] = (a * c - b * keep * omega * s, a * s / omega + b * keep * c)
    return [omegas[-1] * state[0], state[1]], [*rows]


def _sample(path: CorrectedPath, joints: Joints, t: float) -> Sample:
    """By differences along the path."""
    s, speed, _ = path.at(t)
    small = 1e-5 * abs(path.distance)
    (before, low), (here, extension), (after, high) = joints(s - small), joints(s), joints(s + small)
    slope = (after - before) / (2.0 * small)
    curvature = (after - 2.0 * here + before) / small**2
    return Sample(slope, slope * speed, extension, (high - low) / (2.0 * small) * speed, curvature * speed)


def _metric(count: int) -> list[list[float]]:
    """∫B̈_i B̈_j in units of the knot distance: 8/3, −3/2, 0, 1/6 by how far apart the splines are."""
    overlap = (8.0 / 3.0, -1.5, 0.0, 1.0 / 6.0)
    return [[overlap[abs(i - j)] if abs(i - j) < SPAN else 0.0 for j in range(count)] for i in range(count)]


def _least(metric: list[list[float]], jacobian: list[list[float]], wanted: list[float]) -> list[float]:
    """The c with J c = wanted and least cᵀQc."""
    spread = _solved(metric, jacobian)  # rows of Q⁻¹Jᵀ, transposed
    normal = [[sum([a * b for a, b in zip(one, other, strict=True)]) for other in jacobian] for one in spread]
    largest = max(normal[k][k] for k in range(len(normal)))
    for k in range(len(normal)):
        normal[k][k] += RIDGE * largest
    (multipliers,) = _solved(normal, [wanted])
    return [sum([m * row[i] for m, row in zip(multipliers, spread, strict=True)]) for i in range(len(metric))]


def _solved(matrix: list[list[float]], right: list[list[float]]) -> list[list[float]]:
    """Solutions of matrix · x = r for every r, by elimination; the matrix is symmetric and positive definite, so no pivots are needed."""
    size = len(matrix)
    a, solutions = [list(row) for row in matrix], [list(r) for r in right]
    for k in range(size):
        for i in range(k + 1, size):
            factor = a[i][k] / a[k][k]
            if factor == 0.0:
                continue
            for j in range(k, size):
                a[i][j] -= factor * a[k][j]
            for x in solutions:
                x[i] -= factor * x[k]
    for x in solutions:
        for k in range(size - 1, -1, -1):
            x[k] = (x[k] - sum([a[k][j] * x[j] for j in range(k + 1, size)])) / a[k][k]
    return solutions
