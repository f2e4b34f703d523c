"""Logs of a servo cylinder that is no simulation of ours: other equations of friction, another integrator, noise, stops, gaps.

    python -m benchmarks.gap.cylinder_bench DIR

Writes what a laboratory hands over: CSV files in its own columns and units, of a 16/10 mm cylinder of 200 mm on a 10 l/min servovalve
at 70 bar. The tutorial (docs/guide/start/tutorial-cylinder.md) finds its friction from them. Friction is Dahl's (P. Dahl, A Solid Friction
Model, 1968) with a Coulomb level of 75 N and 120 N s/m beside it; the integrator is the classical Runge-Kutta method with 10 us steps.

| file | what |
|---|---|
| steps.csv | steps of the command, 0.3 to 6 V either way, 2 s each; rests on the stop twice |
| short_steps_1.csv … 8.csv | steps of 1 V to 5 V, 0.9 s each, a file a step |
| sine.csv | a sum of three sines; the pressure of the rod side only |
| gaps.csv | as steps.csv with other voltages, and 3 s not recorded |
| free_steps.csv | small steps that stay off the stops |
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np

COULOMB_N, VISCOUS_N_S_PER_M = 75.0, 120.0
PERIOD_S, STEP_S = 0.001, 1e-5
STROKE_M = 0.2
Array = np.ndarray[Any, np.dtype[np.float64]]

_BORE, _ROD, _MASS = 0.016, 0.010, 5.0
_AREA_A, _AREA_B = np.pi / 4 * _BORE**2, np.pi / 4 * (_BORE**2 - _ROD**2)
_SUPPLY, _TANK, _BULK, _DEAD = 70e5, 2e5, 1.3e9, 20e-6
_LAND = 10e-3 / 60 / np.sqrt(70e5 / 2) / 10.0  # m³/s/√Pa a volt
_VALVE_RAD_S, _VALVE_DAMPING = 400.0, 0.9
_LEAK = 4e-14
_ROUND_V = 0.15  # both edges of the spool leak about null
_BRISTLE = 4e6
_STOP = 4e7


@numba.njit
def _flow(drop: float) -> float:
    return np.sign(drop) * np.sqrt(abs(drop))


@numba.njit
def _rates(y: Array, command: float, into: Array) -> None:
    """Position, speed, pressures A and B, spool (V), spool rate, bristle."""
    x, v, a, b, u, w, z = y[0], y[1], y[2], y[3], y[4], y[5], y[6]
    ahead, back = 0.5 * (np.sqrt(u * u + _ROUND_V**2) + u), 0.5 * (np.sqrt(u * u + _ROUND_V**2) - u)
    q_a = _LAND * (ahead * _flow(_SUPPLY - a) - back * _flow(a - _TANK))
    q_b = _LAND * (back * _flow(_SUPPLY - b) - ahead * _flow(b - _TANK))
    leak = _LEAK * (a - b)
    stop = -_STOP * (x - STROKE_M) - 4e3 * v if x > STROKE_M else (-_STOP * x - 4e3 * v if x < 0.0 else 0.0)
    friction = _BRISTLE * z + VISCOUS_N_S_PER_M * v
    into[0] = v
    into[1] = (_AREA_A * a - _AREA_B * b - friction + stop) / _MASS
    into[2] = _BULK / (_DEAD + _AREA_A * x) * (q_a - leak - _AREA_A * v)
    into[3] = _BULK / (_DEAD + _AREA_B * (STROKE_M - x)) * (q_b + leak + _AREA_B * v)
    into[4] = w
    into[5] = _VALVE_RAD_S**2 * (command - u) - 2 * _VALVE_DAMPING * _VALVE_RAD_S * w
    into[6] = v * (1.0 - _BRISTLE / COULOMB_N * z * np.sign(v))


@numba.njit
def _run(commands: Array, start: float) -> Array:
    """State at every row of the log; the command is held from each row to the next."""
    y = np.array([start, 0.0, 35e5, 35e5 * _AREA_A / _AREA_B, 0.0, 0.0, 0.0])
    found = np.empty((len(commands), 7))
    k = np.empty((4, 7))
    for row in range(len(commands)):
        found[row] = y
        for _ in range(round(PERIOD_S / STEP_S)):
            _rates(y, commands[row], k[0])
            _rates(y + 0.5 * STEP_S * k[0], commands[row], k[1])
            _rates(y + 0.5 * STEP_S * k[1], commands[row], k[2])
            _rates(y + STEP_S * k[2], commands[row], k[3])
            y = y + STEP_S / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])
    return found


def measured(commands: Array, start_m: float, seed: int) -> dict[str, Array]:
    """The columns of a log as the laboratory writes them: s, mm, V and bar, with the noise of its sensors."""
    states, noise = _run(commands, start_m), np.random.default_rng(seed)
    rows = len(commands)
    return {
        "time_s": PERIOD_S * np.arange(rows),
        "stroke_mm": np.round((1e3 * states[:, 0] + 0.005 * noise.standard_normal(rows)) / 0.005) * 0.005,
        "valve_V": commands,
        "pA_bar": 1e-5 * states[:, 2] + 0.15 * noise.standard_normal(rows),
        "pB_bar": 1e-5 * states[:, 3] + 0.15 * noise.standard_normal(rows),
        "ps_bar": 1e-5 * _SUPPLY + 0.15 * noise.standard_normal(rows),
    }


def steps(volts: list[float], each_s: float) -> Array:
    return np.repeat(np.array(volts), round(each_s / PERIOD_S))


def logs() -> dict[str, dict[str, Array]]:
    """Name → columns."""
    first = [0.0, 0.3, -0.3, 0.6, -0.6, 1.0, -1.0, 6.0, 2.0, -0.8, -6.0, -1.0, 0.5, 0.0]
    found = {"steps": measured(steps(first, 1.5), 0.1, 1)}
    for number, volts in enumerate((1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 0.5, -0.5), start=1):
        shape = np.concatenate([steps([0.0], 0.2), steps([volts], 0.12 / abs(volts)), steps([0.0], 0.35)])
        found[f"short_steps_{number}"] = measured(shape, 0.1, 10 + number)
    t = PERIOD_S * np.arange(round(12.0 / PERIOD_S))
    wave = 0.9 * np.sin(2 * np.pi * 0.5 * t) + 0.7 * np.sin(2 * np.pi * 1.7 * t + 1.0) + 0.4 * np.sin(2 * np.pi * 4.1 * t + 2.0) - 0.1
    found["sine"] = {name: values for name, values in measured(wave, 0.1, 2).items() if name != "pA_bar"}
    second = [0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2, 0.2, -0.2, 0.0]
    whole = measured(steps(second, 1.5), 0.1, 3)
    keep = (whole["time_s"] < 5.0) | (whole["time_s"] > 8.0)
    found["gaps"] = {name: values[keep] for name, values in whole.items()}
    small = [0.0, 0.3, -0.3, 0.5, -0.5, 0.2, -0.2, 0.6, -0.6, 0.4, -0.4, 0.1, -0.1, 0.0]
    found["free_steps"] = measured(steps(small, 0.9), 0.1, 4)
    return found


def write_table(path: Path, columns: dict[str, Array]) -> None:
    """One CSV, the names of the columns in its first line."""
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.7g")


def write(folder: Path, progress: Callable[[str], None]) -> None:
    """A CSV of every log."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, columns in logs().items():
        path = folder / f"{name}.csv"
        write_table(path, columns)
        progress(f"{path}: {len(columns['time_s'])} rows")


if __name__ == "__main__":
    write(Path(sys.argv[1] if len(sys.argv) > 1 else "cylinder"), print)
