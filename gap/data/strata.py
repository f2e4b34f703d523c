"""Which windows of long logs take part in fits: as many of rest, slow and fast motion and reversal as there are, evenly over time.

A fit needs every regime, not every second; nor does the judge, which fits sets to the hold-out as well, and counts its windows as those of
the fit logs. Costs in noise floors are over all windows of the hold-out.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gap.data.measured import Array
from sim_backend.memory.layout import SLOTS

MOST_WINDOWS = 80  # of all fit logs together, and of all of the hold-out; of 70 to 90, more changed nothing
BLOCK = 3  # neighbouring windows chosen together: what one of them remembers is the end of the one before
_AT_REST = 0.02  # of the largest speed of a joint in the log

Numbers = NDArray[np.int64]


def chosen(velocities: Sequence[Array], most: int = MOST_WINDOWS) -> list[Numbers]:
    """Numbers of the windows to fit, for each log; `velocities`: per log windows × samples × slots (NaN: not measured)."""
    windows = [len(v) for v in velocities]
    if sum(windows) <= 1.25 * most:
        return [np.arange(n) for n in windows]
    share = [max(most * n // sum(windows), 2 * BLOCK) for n in windows]
    return [_of_log(v, count) for v, count in zip(velocities, share, strict=True)]


def _of_log(velocities: Array, count: int) -> Numbers:
    """Blocks in turn from every regime until there are `count` windows."""
    regimes = regime(velocities)
    blocks = [np.arange(first, min(first + BLOCK, len(regimes))) for first in range(0, len(regimes), BLOCK)]
    groups: dict[tuple[int, ...], list[Numbers]] = {}
    for block in blocks:
        groups.setdefault(tuple(int(n) for n in regimes[block].max(axis=0)), []).append(block)
    waiting = [_spread(group) for _, group in sorted(groups.items())]
    taken: list[Numbers] = []
    while sum(map(len, taken)) < count and any(waiting):
        for group in waiting:
            if group and sum(map(len, taken)) < count:
                taken.append(group.pop(0))
    return np.sort(np.concatenate(taken))


def regime(velocities: Array) -> NDArray[np.int64]:
    """Regime of every window and slot: 0 rest, 1 slow, 2 fast, 3 reversal; windows × slots."""
    found = np.zeros((len(velocities), SLOTS), dtype=np.int64)
    for slot in range(SLOTS):
        v = np.nan_to_num(velocities[:, :, slot])
        top = float(np.abs(v).max(initial=0.0))
        if top == 0.0:
            continue
        level = np.abs(v).mean(axis=1)
        moving = np.abs(v).max(axis=1) > _AT_REST * top
        middle = float(np.median(level[moving])) if moving.any() else 0.0
        turns = (v.max(axis=1) > _AT_REST * top) & (v.min(axis=1) < -_AT_REST * top)
        found[:, slot] = np.where(turns, 3, np.where(~moving, 0, np.where(level > middle, 2, 1)))
    return found


def _spread(group: list[Numbers]) -> list[Numbers]:
    """The blocks of a group in an order of which every beginning lies evenly over time (bit reversal)."""
    bits = max(len(group) - 1, 1).bit_length()
    order = sorted(range(len(group)), key=lambda k: int(f"{k:0{bits}b}"[::-1], 2))
    return [group[k] for k in order]
