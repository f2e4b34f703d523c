"""Each effect's own variable, against which what it leaves shows its shape: friction against velocity, a dead band against the command.

What a window leaves in a position is the integral of what is missing. Its rate (flow and valve effects, hydraulic joints) or its
acceleration (forces on a plain servo axis) is drawn, so that the shape is that of the effect and not of its integral.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_filter

from config.schema.effect_library import EFFECTS
from config.schema.rig import Rig
from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation
from gap.outcome.localise import operating_values

_SPAN = 11  # samples of the local cubic that gives rates


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """Abscissa and ordinate of one effect: names with units, and where to look."""

    channel: str
    variable: str
    left: str
    unit: str  # of what is left (SI)
    derivative: int  # of what is left


def fingerprint_of(effect: str, where: str, channels: Sequence[str], fallback: str, rig: Rig) -> Fingerprint:
    """Where an effect shows: the position of its joint, its sensor, the tip for the link; else the channel `fallback`."""
    channel = next((name for name in _homes(where) if name in channels), fallback)
    return seen_in(channel, EFFECTS[effect].variable, rig)


def seen_in(channel: str, kind: str, rig: Rig) -> Fingerprint:
    """The variable of the channel's own joint; of the first joint for what belongs to no joint."""
    joint = channel.split(".")[0]
    joint = joint if joint in rig.joints else next(iter(rig.joints))
    variable = channel if kind == "reading" else f"{joint}.{kind}"
    if not channel.endswith(".position") or kind == "reading":
        return Fingerprint(channel, variable, "left over", "", 0)
    plain = rig.plant is not None and not rig.plant.joints[joint].is_hydraulic
    unit = rig.joints[joint].position_unit
    if plain and kind in ("velocity", "acceleration", "position"):
        return Fingerprint(channel, variable, "acceleration left over", f"{unit}/s^2", 2)
    return Fingerprint(channel, variable, "rate left over", f"{unit}/s", 1)


def _homes(where: str) -> list[str]:
    if where.startswith("sensor:"):
        return [where.removeprefix("sensor:")]
    if where == "link":
        return ["tip.deflection", "tip.acceleration", "rotary.position"]
    return [f"{where}.position"]


def abscissa(evaluation: Evaluation, variable: str, rig: Rig) -> Array:
    """The variable in every window, windows × samples."""
    known: Mapping[str, Array] = operating_values(evaluation, rig)
    if variable in known:
        return known[variable]
    joint, _, kind = variable.rpartition(".")
    if joint not in rig.joints:  # a sensor's own reading, as that of the tip's accelerometer
        return _reading(evaluation, variable)
    step_s = evaluation.experiment.plan.every * evaluation.experiment.log.period_s
    if kind == "acceleration":
        return np.asarray(savgol_filter(known[f"{joint}.velocity"], _SPAN, 2, deriv=1, delta=step_s, axis=1))
    if kind == "command_rate":
        return np.asarray(np.gradient(known[f"{joint}.command_V"], step_s, axis=1))
    return _reading(evaluation, variable)


def unit_of(variable: str, rig: Rig) -> str:
    """SI unit of an operating variable of a joint; empty for anything else."""
    joint, _, kind = variable.rpartition(".")
    if joint not in rig.joints:
        return ""
    length = rig.joints[joint].position_unit
    units = {
        "velocity": f"{length}/s",
        "acceleration": f"{length}/s^2",
        "position": length,
        "command_rate": "V/s",
        "command_V": "V",
        "since_reversal_s": "s",
    }
    return units.get(kind, "")


def ordinate(evaluation: Evaluation, channel: int, derivative: int) -> Array:
    """What is left of a channel in its own unit, or the derivative of that, windows × samples."""
    shape = evaluation.experiment.measured.shape
    left = evaluation.left[:, : shape[1] * shape[2]].reshape(shape)[:, :, channel] * evaluation.experiment.sigma[channel]
    if derivative == 0:
        return np.asarray(left)
    step_s = evaluation.experiment.plan.every * evaluation.experiment.log.period_s
    return np.asarray(savgol_filter(left, 3 * _SPAN if derivative == 2 else _SPAN, 3, deriv=derivative, delta=step_s, axis=1))


def _reading(evaluation: Evaluation, channel: str) -> Array:
    """NaN where the log lacks the channel."""
    plan, channels = evaluation.experiment.plan, evaluation.experiment.log.channels
    rows = plan.starts[:, None] + plan.every * np.arange(plan.samples)[None, :]
    return np.asarray(channels[channel].values[rows]) if channel in channels else np.full(rows.shape, np.nan)
