"""One joint's servo: notch and lag-lead on the error, feed-forward of the reference rate, null bias, limits with anti-windup.

(C2) of docs/method/control.md:

u = C(z)·(reference − position + correction) + k_v · reference rate + k_a · reference acceleration + bias + excitation ± dither
    [+ compensation of the oil's temperature, with the friction that the feedback has to overcome]
"""

from __future__ import annotations

from math import isfinite, nan
from typing import Any

from config.schema.rig import AnyJoint
from config.schema.servo import AnyServo, RotaryServo
from servo_control.numerics.limits import CommandLimit, clamp
from servo_control.numerics.table import between
from servo_control.servo.lag_lead import LagLead
from servo_control.servo.link_notch import LinkNotch
from servo_control.servo.oil_compensation import OilCompensation
from servo_control.servo.velocity import VelocityEstimate

# The bias is faded in after the servo engages: a valve must not be kicked by arming.
BIAS_FADE_S = 0.5
# A position beyond this (rad or m) is a broken sample, not a place; NaN and infinity fail the same comparison.
FARTHEST = 1e4


class JointServo:
    """Makes a command in volts from reference and measured position. A broken sample is replaced by the last good one:
    one lost sample does no harm, and a lasting loss is an interlock's business.
    """

    __slots__ = (
        "_acceleration_gain", "_bias", "_bias_step", "_command_limit", "_compensator", "_dither", "_feedforward", "_full_bias", "_notch",
        "_oil", "_rate_before", "_schedule", "_travel", "_velocity", "command_V", "position",
    )  # fmt: skip

    def __init__(self, joint: AnyJoint, servo: AnyServo, period_s: float, notch: LinkNotch | None = None) -> None:
        corners = [(section.zero_rad_per_s, section.pole_rad_per_s) for section in servo.sections]
        self._compensator = LagLead(servo.gain, corners, period_s)
        schedule = servo.gain_schedule if isinstance(servo, RotaryServo) else ()
        self._notch = notch
        self._schedule = [point.extension_m for point in schedule], [servo.gain * point.factor for point in schedule]
        self._feedforward = servo.velocity_feedforward
        self._acceleration_gain = servo.acceleration_feedforward / period_s
        self._rate_before = 0.0
        self._dither = servo.dither_V
        self._command_limit = CommandLimit(joint.command_limit_V, joint.command_rate_limit_V_per_s, period_s)
        self._velocity = VelocityEstimate(servo.velocity_filter_Hz, period_s)
        self._full_bias = servo.null_bias_V
        oil = servo.oil_compensation
        self._oil = OilCompensation(oil, servo.velocity_feedforward, period_s) if oil is not None else None
        largest_V = abs(servo.null_bias_V) + (self._oil.largest_bias_V if self._oil is not None else 0.0)
        self._bias_step = largest_V * period_s / BIAS_FADE_S
        self._travel = joint.travel
        self._bias = 0.0
        self.position = nan  # last finite measurement
        self.command_V = 0.0

    @property
    def velocity(self) -> float:
        """Estimated velocity (rad/s or m/s); NaN before the first finite position."""
        return self._velocity.velocity if isfinite(self.position) else nan

    def measure(self, position: float) -> None:
        """Take this cycle's sample."""
        if -FARTHEST < position < FARTHEST:
            self.position = position
        if isfinite(self.position):
            self._velocity.step(self.position)

    def measure_oil(self, temperature_C: float) -> None:
        """Take this cycle's oil temperature; NaN where it was lost. Nothing happens on a joint without compensation."""
        if self._oil is not None:
            self._oil.measure(temperature_C)

    def follow_extension(self, extension_m: float) -> None:
        """Take gain and notch for this extension (m); they stay where it is not known. Nothing happens without gain schedule and notch."""
        if self._notch is not None:
            self._notch.follow(extension_m)
        extensions, gains = self._schedule
        if extensions and isfinite(extension_m):
            below, above, share = between(extensions, extension_m)
            self._compensator.set_gain(gains[below] + share * (gains[above] - gains[below]))

    def release(self) -> None:
        """Command 0, memory empty: as before the servo was ever engaged."""
        self.command_V = 0.0
        self._bias = 0.0

    def engage(self) -> None:
        """Start at rest with the reference at the measured position: the command goes on from where it is."""
        self._compensator.preload(0.0, self.command_V)
        if self._notch is not None:
            self._notch.reset()
        self._rate_before = 0.0
        self._dither = abs(self._dither)

    def step(self, reference: float, reference_rate: float, excitation_V: float, correction: float = 0.0, push: float = 0.0) -> None:
        """One cycle; the result is in `command_V`. `correction` and `push` come from the end-point feedback."""
        error = reference - self.position
        if self._notch is not None:
            error = self._notch.step(error)
        if correction != 0.0:  # adding 0.0 would turn -0.0 into 0.0, and logs without feedback re-execute bit for bit
            error += correction
        full_bias = self._full_bias if self._oil is None else self._full_bias + self._oil.bias_V
        self._bias = clamp(full_bias, self._bias - self._bias_step, self._bias + self._bias_step)
        inside = self._travel[0] <= self.position <= self._travel[1]
        wanted = self._compensator.step(error) + self._feedforward * reference_rate + self._bias + (excitation_V if inside else 0.0)
        if self._oil is not None:
            wanted += self._oil.volts(reference_rate, push)
        if self._acceleration_gain != 0.0:
            wanted += self._acceleration_gain * (reference_rate - self._rate_before)
            self._rate_before = reference_rate
        if self._dither != 0.0:
            wanted += self._dither
            self._dither = -self._dither
        limited = self._command_limit.apply(wanted, self.command_V)
        if limited != wanted:
            self._compensator.condition(error, limited - wanted)
        self.command_V = limited

    def snapshot(self) -> dict[str, Any]:
        position = self.position if isfinite(self.position) else None
        return {
            "compensator": self._compensator.snapshot(),
            "velocity": self._velocity.snapshot(),
            "bias": self._bias,
            "oil": self._oil.snapshot() if self._oil is not None else None,
            "notch": self._notch.snapshot() if self._notch is not None else None,
            "position": position,
            "rate_before": self._rate_before,
            "dither_V": self._dither,
            "command_V": self.command_V,
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._compensator.restore(state["compensator"])
        self._velocity.restore(state["velocity"])
        self._bias = state["bias"]
        if self._oil is not None and state.get("oil") is not None:  # none in a log of a rig without compensation
            self._oil.restore(state["oil"])
        if self._notch is not None and state.get("notch") is not None:
            self._notch.restore(state["notch"])
        self.position = nan if state["position"] is None else state["position"]
        self._rate_before = state.get("rate_before", 0.0)  # neither is in a log of an earlier version
        self._dither = state.get("dither_V", self._dither)
        self.command_V = state["command_V"]
