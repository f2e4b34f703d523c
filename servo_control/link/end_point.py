"""Reflected-tip feedback: the rotary joint moves so that it damps the flexible link (positive deformation feedback;
D. Wang and M. Vidyasagar, Int. J. Robotics Research 10, 1991), (C5) of docs/method/control.md.

    w_f += (1 − e^{−2π f_r T}) (w − ŵ − w_f);   correction = g(L) · [w_f + lead] / L   is added to the rotary error

A fast link needs lead: low-pass and joint turn its oscillation by as much as a quarter of a period, and the feedback would no longer damp
it. `lead_shares` turns it back, by the phase that the lag makes at the frequency the link is believed to have.

While the reference rests, a part of the joint's friction is overcome in the direction of the correction as well (`push`).
ŵ is the deflection that the reference motion causes by itself (`servo_control.link.expected_deflection`).

With a rate-type joint this damps the first mode for every joint gain; the second mode has the wrong sign where payload is small or
the arm retracted, hence the low-pass and the gain that goes to 0 as the link gets stiff. The whole correction is faded in after
engaging and out when the signal is lost, so that neither kicks the valve.
"""

from __future__ import annotations

from math import cos, exp, isfinite, pi, sin
from typing import Any

from config.schema.end_point import EndPoint
from config.schema.rig import LinkMode
from servo_control.link.estimator import TipEstimator
from servo_control.link.expected_deflection import ExpectedDeflection
from servo_control.link.link_mode import LinkFrequency
from servo_control.numerics.limits import clamp


def scheduled_gain(settings: EndPoint, frequency_Hz: float) -> float:
    """Gain at a link frequency: full below `full_below`, 0 above `off_above`."""
    share = (settings.off_above_Hz - frequency_Hz) / (settings.off_above_Hz - settings.full_below_Hz)
    return settings.gain * clamp(share, 0.0, 1.0)


def lead_shares(settings: EndPoint, frequency_Hz: float) -> tuple[float, float]:
    """How much of the low-passed deflection and of the part that the low-pass takes away is fed back: (1, 0) without lead.

        cos φ · w_f + sin φ · ẇ_f/ω,    ẇ_f = 2π f_r (w − w_f),    φ = ω · lead

    turns an oscillation at ω ahead by φ, at most by a quarter of a period: with more, a slower link, one heavier than believed, would
    be fed back with the wrong sign. The lead comes in between lead_from and lead_full: where the link is slow, one lighter than believed
    is many times as fast, and lead would feed it back too strongly.
    """
    ramp = (frequency_Hz - settings.lead_from_Hz) / (settings.lead_full_Hz - settings.lead_from_Hz)
    angle = min(2.0 * pi * frequency_Hz * settings.lead_s * clamp(ramp, 0.0, 1.0), 0.5 * pi)
    if angle == 0.0:
        return 1.0, 0.0
    return cos(angle), sin(angle) * settings.roll_off_Hz / frequency_Hz


class EndPointFeedback:
    """The correction of the rotary error in rad. One `step` a cycle while the servo is engaged, `release` otherwise."""

    __slots__ = (
        "_estimator",
        "_expected",
        "_fade",
        "_filtered_m",
        "_frequency",
        "_in_step",
        "_lasting",
        "_lasting_share",
        "_lost_m",
        "_omega",
        "_out_step",
        "_settings",
        "_share",
        "_travel",
    )

    def __init__(self, settings: EndPoint, link: LinkMode, travel: tuple[float, float], period_s: float) -> None:
        """`travel` of the prismatic joint (m): a broken sample of the extension must not become a frequency."""
        self._settings, self._travel = settings, travel
        self._frequency = LinkFrequency(link)
        self._share = 1.0 - exp(-2.0 * pi * settings.roll_off_Hz * period_s)
        self._in_step = period_s / settings.fade_s
        self._out_step = period_s / settings.loss_fade_s
        self._estimator = TipEstimator(settings, link, period_s) if settings.source == "acceleration" else None
        self._expected = ExpectedDeflection(link, period_s)
        self._filtered_m = 0.0
        self._lost_m = 0.0  # what the low-pass takes away of the last good sample
        self._fade = 0.0
        self._omega = 0.0  # of the link, in the last cycle
        self._lasting = 0.0  # rad, what stays in the correction
        self._lasting_share = 1.0 - exp(-2.0 * pi * settings.friction_high_pass_Hz * period_s)

    def release(self) -> None:
        """As before the feedback was ever used."""
        self._filtered_m = self._lost_m = self._fade = self._lasting = 0.0
        if self._estimator is not None:
            self._estimator.reset()
        self._expected.reset()

    def step(self, tip: tuple[float, float], measured: tuple[float, float, float], planned: tuple[float, float, float]) -> float:
        """One cycle. `tip`: deflection and acceleration (NaN where lost; m, m/s²); `measured` and `planned`: extension, its rate, rotary
        rate (m, m/s, rad/s).
        """
        (deflection_m, acceleration), (extension_m, length_rate, rotary_rate) = tip, measured
        length = clamp(extension_m, *self._travel)
        if self._estimator is not None:
            good = isfinite(acceleration)
            deflection_m = self._estimator.step(acceleration, length, length_rate, rotary_rate)
        else:
            good = isfinite(deflection_m)
        limit_m = self._settings.limit_rad * length
        expected_m = self._expected.step(clamp(planned[0], *self._travel), planned[1], planned[2])
        if good:
            beyond_m = clamp(deflection_m - expected_m, -limit_m, limit_m)
            self._filtered_m += self._share * (beyond_m - self._filtered_m)
            self._lost_m = beyond_m - self._filtered_m
            self._fade = min(1.0, self._fade + self._in_step)
        else:
            self._fade = max(0.0, self._fade - self._out_step)
        self._omega = self._frequency.omega_d(length)
        frequency_Hz = self._omega / (2.0 * pi)
        gain = self._fade * scheduled_gain(self._settings, frequency_Hz)
        kept, lead = lead_shares(self._settings, frequency_Hz)
        if lead == 0.0:
            return gain * self._filtered_m / length
        return gain * (kept * self._filtered_m + lead * self._lost_m) / length

    def push(self, correction: float) -> float:
        """Share of the friction of a resting joint to be overcome for the correction (rad) of this cycle, before the servo limits it;
        call it once a cycle.

        A joint in the grip of its friction does not follow small corrections: the link would ring on below about 0.5 m/s². Volts that
        leave less than the friction can hold cannot turn the joint by themselves, they only make it follow. In a joint that stands the
        oil's pressure is the integral of the flow, so a faster link needs more of them. What lasts is a sensor that is off, no vibration:
        it must not use the share up.
        """
        self._lasting += self._lasting_share * (correction - self._lasting)
        return self._settings.friction_gain * self._omega * (correction - self._lasting)

    def snapshot(self) -> dict[str, Any]:
        estimator = self._estimator.snapshot() if self._estimator is not None else None
        return {
            "filtered": self._filtered_m,
            "lost": self._lost_m,
            "fade": self._fade,
            "lasting": self._lasting,
            "estimator": estimator,
            "expected": self._expected.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        self._filtered_m, self._fade = state["filtered"], state["fade"]
        self._lost_m, self._lasting = state.get("lost", 0.0), state.get("lasting", 0.0)  # not in a log of an earlier version
        if self._estimator is not None:
            self._estimator.restore(state["estimator"])
        self._expected.restore(state["expected"])
