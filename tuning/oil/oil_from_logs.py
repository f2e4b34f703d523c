"""The table of a joint's oil compensation from logs of ordinary moves: command, rate and oil temperature wherever the rate is steady."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from config.schema.rig import Rig
from recording.files.reader import Log
from servo_control.signals import Mode
from tuning.arrays import Floats
from tuning.oil.oil_table import LEAST_SPREAD, OilRow, fitted_row

STEADY_S = 0.1  # over which the reference's rate changes little
STEADY_SHARE, SLOWEST_SHARE = 0.05, 0.05  # of the joint's rate limit: that change, and the slowest rate that counts
BIN_K = 5.0
FEWEST_S = 1.0  # of motion in each direction


@dataclass(frozen=True, slots=True, eq=False)
class Steady:
    """Steady motion of one joint in one log: temperature (degC), rate (rad/s or m/s) and command (V), one value a cycle."""

    temperature_C: Floats
    rate: Floats
    command_V: Floats
    period_s: float


def steady_motion(log: Log, rig: Rig, joint: str) -> Steady:
    """What the log has of it; empty when nothing moves steadily or the oil is not measured."""
    columns, period_s = log.columns, 1.0 / rig.loop.rate_Hz
    wanted, limit = np.nan_to_num(columns[f"{joint}.reference_rate"]), rig.joints[joint].rate_limit
    back = round(STEADY_S / period_s)
    temperature = np.asarray(columns[f"{joint}.return_temperature_C"], dtype=np.float64)
    rate, command = (np.asarray(columns[f"{joint}.{name}"], dtype=np.float64) for name in ("velocity", "command_V"))
    rows = (columns["mode"] == Mode.RUNNING) & (np.abs(wanted) > SLOWEST_SHARE * limit)
    rows &= np.isfinite(temperature) & np.isfinite(rate) & np.isfinite(command)
    rows[:back] = False
    rows[back:] &= np.abs(wanted[back:] - wanted[:-back]) < STEADY_SHARE * limit
    return Steady(temperature[rows], rate[rows], command[rows], period_s)


def oil_rows(samples: Sequence[Steady]) -> list[OilRow]:
    """One row for every 5 K in which both directions moved long enough at different speeds, by rising temperature."""
    temperature, rate, command = (
        np.concatenate([getattr(each, name) for each in samples]) for name in ("temperature_C", "rate", "command_V")
    )
    fewest = FEWEST_S / samples[0].period_s
    found = []
    for step in np.unique(np.round(temperature / BIN_K)):
        rows = np.round(temperature / BIN_K) == step
        speeds = np.abs(rate[rows])
        enough = min(np.sum(rate[rows] > 0.0), np.sum(rate[rows] < 0.0)) >= fewest
        if enough and np.std(speeds) > LEAST_SPREAD * np.mean(speeds):
            found.append(fitted_row(float(np.mean(temperature[rows])), rate[rows], command[rows]))
    return found
