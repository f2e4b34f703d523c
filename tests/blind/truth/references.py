"""What the servo is asked to do: references of both joints drawn from a seed. Every kind differs from the others in what it shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CENTRE = (0.0, 0.85)  # rad, m
REACH = (0.55, 0.25)  # largest excursion
SPEED = (0.6, 0.22)
ACCELERATION = (2.0, 2.0)  # keeps the tip within the range of its sensors
KINDS = ("strokes", "multisine", "reversals", "stairs")


def reference(kind: str, seed: int, duration_s: float, period_s: float) -> Array:
    """rows × (position, rate of the rotary joint, position, rate of the prismatic one); starts and ends at CENTRE at rest."""
    draw = np.random.default_rng([seed, KINDS.index(kind)])
    columns = []
    for n in range(2):
        position, rate = _KINDS[kind](draw, n, round(duration_s / period_s), period_s)
        columns += [CENTRE[n] + position, rate]
    return np.column_stack(columns)


def through(targets: list[tuple[float, float, float]], rows: int, period_s: float, acceleration: float) -> tuple[Array, Array]:
    """Moves (target, speed, hold) with trapezoidal speed, one after the other while there is time to come home to 0."""
    rate = np.zeros(rows)
    at, k = 0.0, 0
    for target, speed, hold in targets:
        move, home = _move(target - at, speed, acceleration, period_s), _move(-target, speed, acceleration, period_s)
        stay = round(hold / period_s)
        if k + len(move) + stay + len(home) > rows:
            break
        rate[k : k + len(move)] = move
        k, at = k + len(move) + stay, target
    home = _move(-at, max(s for _, s, _ in targets), acceleration, period_s)[: rows - k]
    rate[k : k + len(home)] = home
    return period_s * (np.cumsum(rate) - 0.5 * rate), rate


def _move(distance: float, speed: float, acceleration: float, period_s: float) -> Array:
    """Rates of one move, scaled so that their sum is the distance."""
    speed = max(min(speed, np.sqrt(abs(distance) * acceleration)), 1e-9)
    whole = abs(distance) / speed + speed / acceleration
    t = period_s * (np.arange(int(np.ceil(whole / period_s))) + 0.5)
    v = np.clip(np.minimum(t, whole - t) * acceleration, 0.0, speed)
    return v * distance / max(float(v.sum()) * period_s, 1e-12)


def _strokes(draw: np.random.Generator, n: int, rows: int, period_s: float) -> tuple[Array, Array]:
    moves = [(draw.uniform(-1, 1) * REACH[n], draw.uniform(0.4, 1) * SPEED[n], draw.uniform(0.1, 0.7)) for _ in range(60)]
    return through(moves, rows, period_s, ACCELERATION[n])


def _multisine(draw: np.random.Generator, n: int, rows: int, period_s: float) -> tuple[Array, Array]:
    t = period_s * np.arange(rows)
    lines = draw.choice(np.arange(2, 40), 7, replace=False) * 0.1
    fade = np.clip(np.minimum(t, t[-1] - t), 0, 1)
    position = np.zeros(rows)
    for f in lines:
        position += np.cos(2 * np.pi * (f * t + draw.uniform())) / (1 + (f / 0.8) ** 2)
    position *= fade * (0.07, 0.14)[n] * REACH[n]
    return position, np.gradient(position, period_s)


def _reversals(draw: np.random.Generator, n: int, rows: int, period_s: float) -> tuple[Array, Array]:
    """Back and forth, slowly and ever further, then fast."""
    sizes = REACH[n] * np.geomspace(0.01, 0.5, 9) * draw.uniform(0.8, 1.2, 9)
    speeds = SPEED[n] * np.geomspace(0.03, 0.8, 9)
    moves = [(side * size, speed, draw.uniform(0, 0.3)) for size, speed in zip(sizes, speeds, strict=True) for side in (1, -1)]
    return through(moves, rows, period_s, ACCELERATION[n])


def _stairs(draw: np.random.Generator, n: int, rows: int, period_s: float) -> tuple[Array, Array]:
    """Short quick steps, each held, over the whole reach; the joints take turns."""
    step = 0.25 * REACH[n]
    levels = np.concatenate([np.arange(1, 4), np.arange(2, -4, -1), np.arange(-2, 1)]) * step * draw.choice([-1, 1])
    moves: list[tuple[float, float, float]] = [(0.0, SPEED[n], 0.35 * n)]
    moves += [(level, draw.uniform(0.5, 1) * SPEED[n], draw.uniform(0.35, 0.6)) for level in levels]
    return through(moves, rows, period_s, ACCELERATION[n])


_KINDS = {"strokes": _strokes, "multisine": _multisine, "reversals": _reversals, "stairs": _stairs}
