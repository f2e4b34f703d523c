"""Many simulations of the same logged commands in windows: what a comparison with measurement needs.

`carry` goes through the whole log once and puts joints and link on their measured values at the start of every window; all that is
not measured (spool, hysteresis, delay lines, pressures, temperatures) is carried on. `restart` repeats single windows from the kept
states with one state moved. Both write readings as the sensors give them, without noise and without rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_backend.kernel import kernel
from sim_backend.kernel.measured_state import begin, correct, move
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.compiled import released
from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, S_START, S_STRIDE, SLOTS, C, D, H, J, Kind, S, Target, Vector, X
from sim_backend.memory.work import W_STRIDE, WORK, W, copy, scratch
from sim_backend.physics.sensors import raw_counts
from sim_backend.physics.valve import spool_command

_UNROUNDED = 1e-6  # share of the declared resolution to which readings are rounded here: out of sight, kept for its range

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class WindowPlan:
    """What is simulated: commands (rows × 2 slots, V), first row of every window, rows a window, one reading every `every` rows.

    `targets`: rows × layout.TARGETS, the measured motion at every row, columns as in layout.Target (NaN: carried like everything else).
    Joints whose motion is imposed follow it at every row.
    `entries`: for every window the row at which a simulation may enter with states kept from another one; −1 where it comes from the
    window before. Without them every window is reached through the whole log.
    """

    commands_V: Array
    starts: NDArray[np.int64]
    rows: int
    every: int
    period_s: float
    targets: Array
    entries: NDArray[np.int64] | None = None

    @property
    def samples(self) -> int:
        return (self.rows - 1) // self.every + 1


def quiet(parameters: Parameters) -> Vector:
    """The parameter vector with sensors that neither round, drop samples nor make noise."""
    values = parameters.values.copy()
    for number in range(len(parameters.sensors)):
        q = S_START + number * S_STRIDE
        values[q + S.RESOLUTION] *= _UNROUNDED
        values[q + S.NOISE] = values[q + S.DROPOUT] = 0.0
    return values


def carry(start: Vector, p: Vector, plan: WindowPlan, keep: bool = False, entered: Array | None = None) -> tuple[Array, Array]:
    """Readings (windows × samples × sensors, SI) with parameters `p` from state `start`, its joints where the first row says they are; with
    `keep` also the windows' first states.

    `entered`: windows × states, from which the windows with an entry row are reached instead of through the log before them; their
    hysteresis is made that of `p`.
    Releases the interpreter lock: call it from several threads.
    """
    out = np.empty((len(plan.starts), plan.samples, int(p[C.SENSORS])))
    kept = np.empty((len(plan.starts) if keep else 0, start.size))
    entries = np.full(len(plan.starts), -1) if plan.entries is None or entered is None else plan.entries
    states = np.empty((0, start.size)) if entered is None else entered
    plays = (start[H.PLAY : H.PLAY + SLOTS].copy(), np.zeros(SLOTS, np.int64))
    cut = (plan.commands_V, plan.starts, plan.rows, plan.every, plan.period_s, plan.targets)
    _carry(start.copy(), p, np.zeros(WORK), scratch(), plays, *cut, entries, states, out, kept)
    return out * _resolutions(p), kept


def restart(kept: Array, p: Vector, plan: WindowPlan, state: int, change: float) -> Array:
    """Readings as those of `carry`, every window from its kept state with differential state number `state` moved by `change`."""
    out = np.empty((len(plan.starts), plan.samples, int(p[C.SENSORS])))
    cut = (plan.commands_V, plan.starts, plan.rows, plan.every, plan.period_s, plan.targets)
    _restart(np.empty(kept.shape[1]), kept, p, np.zeros(WORK), scratch(), *cut, state, change, out)
    return out * _resolutions(p)


def _resolutions(p: Vector) -> Vector:
    count = int(p[C.SENSORS])
    return p[S_START + S.RESOLUTION : S_START + count * S_STRIDE : S_STRIDE]


@released
def _impose(x: Vector, p: Vector, w: Vector, targets: Array, row: int) -> None:
    """Put the joints whose motion is imposed on their measured motion."""
    for slot in range(SLOTS):
        if int(p[J_START + slot * J_STRIDE + J.KIND]) == Kind.IMPOSED and not np.isnan(targets[row, Target.ACCELERATION + slot]):
            x[slot * D_STRIDE + D.POSITION] = targets[row, Target.POSITION + slot]
            x[slot * D_STRIDE + D.VELOCITY] = targets[row, Target.VELOCITY + slot]
            w[slot * W_STRIDE + W.IMPOSED_ACCELERATION] = targets[row, Target.ACCELERATION + slot]


@released
def _rows(
    x: Vector,
    p: Vector,
    w: Vector,
    scratch: tuple[Vector, Vector, Vector],
    commands: Array,
    first: int,
    last: int,
    every: int,
    period_s: float,
    targets: Array,
    out: Array,
) -> None:
    """Advance from row `first` to row `last`; a reading every `every` rows goes into the next row of `out`, while there is one."""
    stay = kernel.rates_stay(p)
    for row in range(first, last):
        _impose(x, p, w, targets, row)
        sample = (row - first) // every
        if (row - first) % every == 0 and sample < out.shape[0]:
            raw_counts(x, p, period_s, out[sample])
        kernel.advance(x, p, w, scratch, commands[row, 0], commands[row, 1], period_s, stay and row > first)


@released
def _played(play: float, p: Vector, slot: int, commands: Array, first: int, last: int, temperature_C: float) -> float:
    """State of a slot's hysteresis after the commands of these rows: it follows from the commands alone, whatever the plant did."""
    for row in range(first, last):
        _, play = spool_command(commands[row, slot], play, p, J_START + slot * J_STRIDE, temperature_C)
    return play


@released
def _carry(
    x: Vector,
    p: Vector,
    w: Vector,
    scratch: tuple[Vector, Vector, Vector],
    plays: tuple[Vector, NDArray[np.int64]],
    commands: Array,
    starts: NDArray[np.int64],
    rows: int,
    every: int,
    period_s: float,
    targets: Array,
    entries: NDArray[np.int64],
    entered: Array,
    out: Array,
    kept: Array,
) -> None:
    """`plays`: of every slot, the hysteresis after the commands up to a row, and that row."""
    warmer = p[C.INITIAL_TEMPERATURE] - x[H.OIL]
    for k in range(H.RESERVOIR, H.OIL + 1):
        x[k] += warmer
    x[X.SUPPLY_PRESSURE] = p[C.SUPPLY_PRESSURE]
    x[H.SENSE_PERIOD] = 0.0  # the sensors' lags are those of `p`
    row, (play, played) = 0, plays
    if starts.size > 0 and entries[0] < 0:
        begin(x, p, targets, period_s)
    for i in range(starts.size):
        if entries[i] >= 0:
            row = entries[i]
            copy(entered[i], x)
            x[H.SENSE_PERIOD] = 0.0
            for slot in range(SLOTS):
                arrived = max(row - int(p[J_START + slot * J_STRIDE + J.DELAY] / period_s), played[slot])
                play[slot] = _played(play[slot], p, slot, commands, played[slot], arrived, x[H.OIL])
                x[H.PLAY + slot], played[slot] = play[slot], arrived
            correct(x, p, targets, row, period_s)
        _rows(x, p, w, scratch, commands, row, starts[i], every, period_s, targets, out[i, :0])
        correct(x, p, targets, starts[i], period_s)
        if kept.shape[0] > 0:
            copy(x, kept[i])
        row = starts[i] + rows
        _rows(x, p, w, scratch, commands, starts[i], row, every, period_s, targets, out[i])


@released
def _restart(
    x: Vector,
    kept: Array,
    p: Vector,
    w: Vector,
    scratch: tuple[Vector, Vector, Vector],
    commands: Array,
    starts: NDArray[np.int64],
    rows: int,
    every: int,
    period_s: float,
    targets: Array,
    state: int,
    change: float,
    out: Array,
) -> None:
    for i in range(starts.size):
        copy(kept[i], x)
        move(x, p, state, change, period_s)
        _rows(x, p, w, scratch, commands, starts[i], starts[i] + rows, every, period_s, targets, out[i])
