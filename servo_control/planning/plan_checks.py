"""Checks of a program before it may run: every cycle's target against travel, rate and acceleration, volts against the command."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from math import ceil
from typing import Any

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.path.joint_limits import JointLimits
from servo_control.path.pieces import Dwell, Piece, Sample
from servo_control.planning.run_plan import Peaks

SLACK = 1.0 + 1e-9  # a trapezoid planned at the limit exceeds it by rounding only
# A piece longer than 300 s at 1 kHz is sampled more coarsely: planning must not hold up whoever asked for it by many seconds, and
# over so many periods the samples still meet the peaks of a wave.
MOST_SAMPLES = 300_000
EXCITATIONS = ("sine_sweep", "multisine")
FASTEST_SHARE = 0.4  # of the loop's rate: two and a half cycles a period


def program_peaks(pieces: Sequence[Piece], joints: Sequence[JointLimits], period_s: float) -> tuple[Peaks, ...]:
    """What the program asks of every joint at most; nothing is refused."""
    low = list(pieces[0].at(0.0)[0])
    high, rate, acceleration = list(low), [0.0] * len(joints), [0.0] * len(joints)
    for _, (positions, rates, accelerations, _volts) in samples(pieces, period_s):
        for j in range(len(joints)):
            low[j], high[j] = min(low[j], positions[j]), max(high[j], positions[j])
            rate[j] = max(rate[j], abs(rates[j]))
            acceleration[j] = max(acceleration[j], abs(accelerations[j]))
    return tuple(Peaks(*values) for values in zip(low, high, rate, acceleration, strict=True))


def program_volts(pieces: Sequence[Piece], joints: Sequence[JointLimits], period_s: float) -> list[float]:
    """The largest excitation on every joint's command."""
    peaks = [0.0] * len(joints)
    for _, sample in samples(pieces, period_s):
        peaks = [max(peak, abs(volts)) for peak, volts in zip(peaks, sample[3], strict=True)]
    return peaks


def check_program(pieces: Sequence[Piece], joints: Sequence[JointLimits], period_s: float, where: str, next_step: str) -> None:
    """Raises ManeuverError for the first cycle outside a limit, and then for where that joint is furthest outside its travel: how much too
    far a way goes does not show where it crosses the limit. `next_step` is the advice for a position outside the travel."""
    each = samples(pieces, period_s)
    for t, (positions, rates, accelerations, _volts) in each:
        for j, joint in enumerate(joints):
            if _outside(joint, positions[j]) > 0.0:
                _check_furthest(joint, [(t, positions[j]), *((later, found[0][j]) for later, found in each)], where, next_step)
            _check_slope(joint, "rate", rates[j], joint.rate, "/s", t, where)
            _check_slope(joint, "acceleration", accelerations[j], joint.acceleration, "/s^2", t, where)


def _check_furthest(joint: JointLimits, positions: Sequence[tuple[float, float]], where: str, next_step: str) -> None:
    t, furthest = max(positions, key=lambda at: _outside(joint, at[1]))
    check_position(joint, furthest, t, where, next_step)


def check_position(joint: JointLimits, position: float, t: float, where: str, next_step: str) -> None:
    """Raises ManeuverError when a joint would leave its travel at time t of the program."""
    if _outside(joint, position) <= 0.0:
        return
    low, high = joint.travel
    below = position < low
    raise ManeuverError(
        f"{'extension' if joint.name == 'prismatic' else joint.name + ' position'} {joint.show(position)} at t = {t:.2f} s is "
        f"{'below' if below else 'above'} the limit {joint.show(low if below else high)}",
        where=where,
        next_step=next_step,
    )


def _outside(joint: JointLimits, position: float) -> float:
    """How far outside its travel; negative inside."""
    low, high = joint.travel
    return max(low - position, position - high) - 1e-9 * (high - low)


def check_band(maneuver: Mapping[str, Any], rig: Rig) -> None:
    """An excitation above half the loop's rate comes out as another frequency, and a little below it as hardly any sine.

    `maneuver`: as in a run's request. Not part of plan_run: a run that was logged is planned again whatever its band.
    """
    if maneuver.get("kind") not in EXCITATIONS:
        return
    highest_Hz = FASTEST_SHARE * rig.loop.rate_Hz
    above = {key: maneuver[key] for key in ("from", "to") if maneuver[key] > highest_Hz}
    if above:
        raise ManeuverError(
            f"the excitation is too fast for the loop, {rig.loop.rate_Hz:g} Hz",
            value=f"{max(above.values()):g}",
            limit=f"{highest_Hz:g}",
            unit="Hz",
            where=f"{maneuver['name']}, {' and '.join(above)}",
            next_step=f"Choose frequencies of at most {highest_Hz:g} Hz, or a faster loop.",
            mend=dict.fromkeys(above, f"{highest_Hz:g} Hz"),
        )


def check_volts(pieces: Sequence[Piece], rig: Rig, joints: Sequence[JointLimits], period_s: float, where: str) -> None:
    """An excitation on the command must stay below the command limit, and the servo must be able to hold the arm against it."""
    for joint, peak in zip(joints, program_volts(pieces, joints, period_s), strict=True):
        if peak > joint.command_V:
            raise ManeuverError(
                f"the excitation of {joint.name} is above the command limit",
                value=f"{peak:g}",
                limit=f"{joint.command_V:g}",
                unit="V",
                where=where,
            )
        allowed, gain = rig.joints[joint.name].following_error_limit, abs(rig.servo[joint.name].gain)
        if peak > 0.0 and peak > allowed * gain:
            raise ManeuverError(
                f"the excitation would push {joint.name} beyond its following error limit (servo gain {gain:g} V/{joint.unit})",
                value=f"{peak / gain:.4g}" if gain else "unbounded",
                limit=f"{allowed:g}",
                unit=joint.unit,
                where=where,
                next_step=f"Choose an amplitude of at most {allowed * gain:.3g} V.",
            )


def _check_slope(joint: JointLimits, word: str, value: float, limit: float, per: str, t: float, where: str) -> None:
    if abs(value) <= limit * SLACK:
        return
    raise ManeuverError(
        f"{joint.name} {word} at t = {t:.2f} s is above the limit",
        value=f"{value:.7g}",
        limit=f"{limit:.7g}",
        unit=joint.unit + per,
        where=where,
        next_step="Choose a lower speed, acceleration, amplitude or frequency.",
    )


def samples(pieces: Sequence[Piece], period_s: float) -> Iterator[tuple[float, Sample]]:
    """Time and sample at every cycle (see MOST_SAMPLES) and at the end of every piece; one sample of a rest."""
    start = 0.0
    for piece in pieces:
        step_s = max(period_s, piece.duration_s / MOST_SAMPLES)
        samples = 0 if isinstance(piece, Dwell) else ceil(piece.duration_s / step_s)
        for t in chain((n * step_s for n in range(samples)), (piece.duration_s,)):
            yield start + t, piece.at(t)
        start += piece.duration_s
