"""What an identification varies when nobody says otherwise: on the paper's arm, and on a single hydraulic axis from its own limits.

The waves of an axis go beyond its resonance, where its damping shows, and are as large as leaves the joint half of its rate and of its
following error; with a fifth of that friction decides more.
"""

from __future__ import annotations

from config.errors import ConfigError
from config.schema.rig import Rig
from tuning.experiments.experiments import Campaign, What, default_places
from tuning.linear.hydraulic_axis import is_hydraulic_axis
from tuning.linear.linear_axis import linear_axis
from tuning.linear.pace import pace_of
from tuning.variants import ROTARY

ARM_AMPLITUDES_V, ARM_BAND_HZ = (0.1, 0.3, 1.0), (0.2, 8.0)
LARGEST_OPENING, HALF = 0.3, 0.5  # of the command limit; of the rate limit and of the following error
AXIS_AMPLITUDES = (0.2, 1.0)  # of the largest
AXIS_BAND_HZ, AXIS_LINES = (0.2, 20.0), 40  # of an axis with the paper's pace; close enough for a resonance
NYQUIST_SHARE = 0.5


def usual_campaign(rig: Rig, what: What) -> Campaign:
    """ConfigError for a rig that no runs are made for, or moves that need a link."""
    if rig.arm.kind == "rotary_prismatic" and rig.plant is not None:
        return Campaign(what, ROTARY, ARM_AMPLITUDES_V, default_places(rig, what), band_Hz=ARM_BAND_HZ)
    if not is_hydraulic_axis(rig):
        raise ConfigError(
            "the runs are made for a rotary_prismatic arm, or one hydraulic axis with its plant",
            value=rig.arm.kind,
            where=rig.name,
            next_step="Record a sine sweep or multisine of your own, then take its log: `longreach identify --log LOG.mcap`.",
        )
    if what in ("map", "payload"):
        advice = "Take --what multisine."
        raise ConfigError("a single axis has no link and no payload at its tip", value=what, where=rig.name, next_step=advice)
    return _of_axis(rig, what)


def _of_axis(rig: Rig, what: What) -> Campaign:
    (joint,) = rig.joints
    places = default_places(rig, "multisine")
    pace = pace_of(rig, linear_axis(rig, places[1]))
    low, high = (pace * edge for edge in AXIS_BAND_HZ)
    amplitudes = tuple(float(f"{share * largest_V(rig):.3g}") for share in AXIS_AMPLITUDES)
    band = low, min(high, NYQUIST_SHARE * 0.5 * rig.loop.rate_Hz)
    return Campaign(what, joint, amplitudes, places, band_Hz=band, lines=AXIS_LINES, pace=pace)


def largest_V(rig: Rig) -> float:
    """Peak on the command."""
    (name,) = rig.joints
    joint, servo = rig.joints[name], rig.servo[name]
    limits = [LARGEST_OPENING * joint.command_limit_V, HALF * joint.following_error_limit * abs(servo.gain)]
    if servo.velocity_feedforward > 0.0:
        limits.append(HALF * joint.rate_limit * servo.velocity_feedforward)
    return min(limit for limit in limits if limit > 0.0)
