"""Shaping without delay: the time law of a move is corrected so that the link is at rest when the move ends,
(S4) of docs/method/shaping.md.

Sought are the spline coefficients c with the least ∫δs̈² for which the link's first mode, driven by the joints over the move with the
extension changing, ends at rest for every frequency of a range around the believed one:

    minimise cᵀQc   subject to   r_k + J_k c = 0,     Q_ij = ∫B̈_i B̈_j,   r_k: what mode k is left with (ω w and ẇ)

c = −Q⁻¹Jᵀ(JQ⁻¹Jᵀ)⁻¹ r, repeated from the corrected path because joints are not linear in s. Plain floats throughout: a plan made again
from its request is the same to the last bit, whatever linear algebra a computer has.

Where the link makes many cycles in a move, beginning and end of the move are corrected by themselves. In between it then follows the
joints without vibrating: (w, v) there is what the slow motion bends it to.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil, cos, sin
from typing import NamedTuple

from config.schema.rig import LinkMode
from servo_control.link.link_mode import LinkFrequency
from servo_control.link.link_motion import carried_arm, one_period
from servo_control.numerics.normal_equations import least_norm
from servo_control.path.corrected_path import SPAN, CorrectedPath, Path, bump
from servo_control.path.trajectory import SmoothRamps, Trapezoid, smoothed

Joints = Callable[[float], tuple[float, float]]  # path position -> (rotary rad, extension m)
KNOTS_A_PERIOD = 4.0
FEWEST_SPLINES = 8
ROUNDS = 3


class Fineness(NamedTuple):
    """How finely a correction is planned.

    Frequencies: `points` + `points_a_cycle` · range · cycles of the link. Splines: four a period, at most `most_splines`. Steps of the
    integration: `step_s`, or `steps_a_period` of the link's if that is finer. `ridge`: of the largest diagonal element, neighbouring
    frequencies ask nearly the same. `end_cycles`: what beginning and end of a fast link's move get each (0: always the whole move).
    `faster`: how much higher a speed ramps without corners may need (0: ramps as planned).
    """

    points: int
    points_a_cycle: float
    most_splines: int
    step_s: float
    steps_a_period: float
    ridge: float
    end_cycles: float
    faster: float


# By the number in the run request: a logged run is planned again as it was. In the first one the range's frequencies lay so far apart
# that up to 0.5 m/s² was left between them, 80 splines were too few for a fast link, and the corners of the ramps, which the joint
# rounds off, left a fast link vibrating.
FINENESS = {1: Fineness(2, 2.0, 80, 0.004, 0.0, 1e-10, 0.0, 0.0), 2: Fineness(5, 4.0, 1000, 0.004, 20.0, 1e-6, 16.0, 1.15)}


class PathSample(NamedTuple):
    """A moment of the move. `slope`: dθ/ds; `rate`: θ̇; `bend`: derivative of θ̇ by s."""

    slope: float
    rate: float
    extension: float
    extension_rate: float
    bend: float


class Task(NamedTuple):
    """What is corrected: the span (s) of the move, where the joints are on the path, the link, and the modes that shall end at rest."""

    span: tuple[float, float]
    joints: Joints
    link: LinkMode
    modes: list[LinkFrequency]
    steps: int
    splines: int


def corrected(path: Trapezoid, joints: Joints, link: LinkMode, scale: float, share: float, fineness: Fineness) -> CorrectedPath:
    """The path that leaves no vibration for frequencies within 1 ± `share` of scale × believed frequency."""
    believed = LinkFrequency(link, scale)
    base = smoothed(path, fineness.faster) if fineness.faster > 0.0 else path
    found: Path = base
    for span in _spans(base, joints, believed, fineness.end_cycles):
        length_s = span[1] - span[0]
        fastest_Hz = _fastest_Hz(base, joints, believed, span)
        cycles = length_s * fastest_Hz
        points = fineness.points + ceil(fineness.points_a_cycle * share * cycles) if share > 0.0 else 1
        modes = [LinkFrequency(link, scale * (1.0 + share * (2.0 * k / max(points - 1, 1) - 1.0))) for k in range(points)]
        count = min(max(round(KNOTS_A_PERIOD * cycles) - SPAN + 1, FEWEST_SPLINES), fineness.most_splines)
        steps = max(1, round(length_s / fineness.step_s), round(fineness.steps_a_period * cycles))
        found = _corrected(found, Task(span, joints, link, modes, steps, count), fineness.ridge)
    assert isinstance(found, CorrectedPath)
    return found


def _spans(path: Trapezoid | SmoothRamps, joints: Joints, mode: LinkFrequency, end_cycles: float) -> list[tuple[float, float]]:
    """The whole move; of a fast link the ramp of speed and some cycles at either end, where those leave something in between."""
    slowest_Hz = min(mode.frequency_Hz(joints(s)[1]) for s in (0.0, path.distance))
    end_s = path.ramp_s + end_cycles / slowest_Hz
    if end_cycles == 0.0 or 2.0 * end_s >= path.duration_s:
        return [(0.0, path.duration_s)]
    return [(0.0, end_s), (path.duration_s - end_s, path.duration_s)]


def _fastest_Hz(path: Path, joints: Joints, mode: LinkFrequency, span: tuple[float, float]) -> float:
    """Where the arm is shortest."""
    first, last = (path.at(t)[0] for t in span)
    return mode.frequency_Hz(min(joints(first + (last - first) * k / 20)[1] for k in range(21)))


def _corrected(path: Path, task: Task, ridge: float) -> CorrectedPath:
    coefficients = [0.0] * task.splines
    for _ in range(ROUNDS):
        residual, jacobian = _linearised(CorrectedPath(path, coefficients, task.span), task)
        # about c = 0: the least correction, not the least change of the last one
        wanted = [r - sum([j * c for j, c in zip(row, coefficients, strict=True)]) for r, row in zip(residual, jacobian, strict=True)]
        coefficients = least_norm(_metric(task.splines), SPAN - 1, jacobian, [-w for w in wanted], ridge)
    return CorrectedPath(path, coefficients, task.span)


def _linearised(path: CorrectedPath, task: Task) -> tuple[list[float], list[list[float]]]:
    """What every mode is left with at the end, and its derivative by the coefficients."""
    begin, end = task.span
    step_s, knot_s = (end - begin) / task.steps, (end - begin) / (task.splines + SPAN - 1)
    samples = [_sample(path, task.joints, begin + (n + 0.5) * step_s) for n in range(task.steps)]
    pushes = [_pushes(sample, (n + 0.5) * step_s, knot_s, task.splines) for n, sample in enumerate(samples)]
    residual, jacobian = [], []
    for mode in task.modes:
        edges = [_bent(path, task, mode, t, step_s) for t in task.span]
        left, rows = _of_mode(mode, task, samples, pushes, edges, step_s)
        residual += left
        jacobian += rows
    return residual, jacobian


def _bent(path: CorrectedPath, task: Task, mode: LinkFrequency, t: float, step_s: float) -> tuple[float, float]:
    """(w, v) of a link that does not vibrate at time t: at rest at the ends of the move, else bent by the joints' slow motion."""
    if t <= 0.0 or t >= path.duration_s:
        return 0.0, 0.0
    before, after = (_sample(path, task.joints, t + side * step_s) for side in (-0.5, 0.5))
    early, late = (carried_arm(task.link, each.extension) * each.rate for each in (before, after))
    forced = (late - early) / step_s + 0.5 * (before.extension_rate * before.rate + after.extension_rate * after.rate)
    return -forced / mode.omega_d(0.5 * (before.extension + after.extension)) ** 2, 0.5 * (early + late)


def _pushes(sample: PathSample, t: float, knot_s: float, count: int) -> list[tuple[int, float]]:
    """Which coefficients change the joint's rate at time t of the span, and by how much: θ̇ = θ'(s) ṡ."""
    newest = int(t / knot_s)
    bumps = [(i, bump(t / knot_s - i)) for i in range(max(0, newest - SPAN + 1), min(newest, count - 1) + 1)]
    return [(i, sample.slope * speed / knot_s + sample.bend * value) for i, (value, speed, _) in bumps]


def _of_mode(
    mode: LinkFrequency,
    task: Task,
    samples: Sequence[PathSample],
    pushes: list[list[tuple[int, float]]],
    edges: Sequence[tuple[float, float]],
    step_s: float,
) -> tuple[list[float], list[list[float]]]:
    """(ω w, ẇ) at the end, and both rows of the derivative: the motion forwards, its adjoint backwards."""
    omegas = [mode.omega_d(sample.extension) for sample in samples]
    arms = [carried_arm(task.link, sample.extension) for sample in samples]
    state, target = edges
    for omega, arm, each in zip(omegas, arms, samples, strict=True):
        drag = 2.0 * mode.damping_ratio * omega
        state = one_period(state, omega, drag, arm * each.rate, each.extension_rate * each.rate, step_s)
    rows = [[0.0] * task.splines, [0.0] * task.splines]
    weights = [(omegas[-1], 0.0), (0.0, 1.0)]  # of (w, v) in what is left; v is ẇ once the joint rests
    for sample, omega, arm, pushed in reversed(list(zip(samples, omegas, arms, pushes, strict=True))):
        damped = 1.0 - 2.0 * mode.damping_ratio * omega * step_s
        for k, row in enumerate(rows):
            by_rate, weights[k] = _step_back(weights[k], omega, damped, arm, sample.extension_rate, step_s)
            for i, push in pushed:
                row[i] += by_rate * push
    return [omegas[-1] * (state[0] - target[0]), state[1] - target[1]], rows


def _step_back(
    weight: tuple[float, float], omega: float, damped: float, arm: float, extension_rate: float, step_s: float
) -> tuple[float, tuple[float, float]]:
    """One step of the adjoint: what is left after the step is weight · (w, v). How it changes with the joint's rate θ̇ in the step, and
    its weights before the step.

    `one_period` is linear in state and rate. With C = cos ωT, S = sin ωT, d = `damped` = 1 − 2ζωT, α = `arm`:

        w⁺ = C w + (S/ω) (v − α θ̇)
        v⁺ = α θ̇ + d (−ω S w + C (v − α θ̇)) − T L̇ θ̇

    so with λ = `weight`, the derivatives of λ_w w⁺ + λ_v v⁺ are

        by θ̇:  −α (λ_w S/ω + λ_v (d C − 1)) − λ_v L̇ T
        by w:  λ_w C − λ_v d ω S
        by v:  λ_w S/ω + λ_v d C

    The last two are the weights before the step. Backwards over all steps this gives the derivative by every rate in one pass.
    """
    on_deflection, on_speed = weight
    cosine, sine = cos(omega * step_s), sin(omega * step_s)
    by_rate = -arm * (on_deflection * sine / omega + on_speed * (damped * cosine - 1.0)) - on_speed * extension_rate * step_s
    before = (on_deflection * cosine - on_speed * damped * omega * sine, on_deflection * sine / omega + on_speed * damped * cosine)
    return by_rate, before


def _sample(path: CorrectedPath, joints: Joints, t: float) -> PathSample:
    """By differences along the path."""
    s, speed, _ = path.at(t)
    small = 1e-5 * abs(path.distance)
    (before, low), (here, extension), (after, high) = joints(s - small), joints(s), joints(s + small)
    slope = (after - before) / (2.0 * small)
    curvature = (after - 2.0 * here + before) / small**2
    return PathSample(slope, slope * speed, extension, (high - low) / (2.0 * small) * speed, curvature * speed)


def _metric(count: int) -> list[list[float]]:
    """∫B̈_i B̈_j in units of the knot distance: 8/3, −3/2, 0, 1/6 by how far apart the splines are."""
    overlap = (8.0 / 3.0, -1.5, 0.0, 1.0 / 6.0)
    return [[overlap[abs(i - j)] if abs(i - j) < SPAN else 0.0 for j in range(count)] for i in range(count)]
