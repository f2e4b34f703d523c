"""Whether a measured position is one the joint can have: rate (a jump), noise, stuck, and motion that the command does not explain; and
whether a second sensor of the motion, where there is one, agrees.

Four numbers a joint and that difference, renewed in every cycle with a new sample and checked like any other fact. They look at the
reference and the command of the last cycle, which is what the sample answers to. Nothing here is logged: the log's own columns give the
same numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import exp, inf, isfinite, nan

from config.rig import Rig
from config.signals import SECOND_POSITION
from control.signals import Mode
from daemon.checks import Check, Reaction
from daemon.facts import APART_FACT, PLAUSIBILITY_FACTS, Facts

NOISE_CYCLES = 10.0  # time constant of the mean: a single odd sample is not noise
FLOW_MEMORY_S = 0.1  # longer than valve and oil need to follow the command (about 10 ms)
LONGEST_HOLD_S = 0.05  # a command that was not renewed for longer may have been ended by the device's own time-out
_SERVO_ACTS = frozenset((int(Mode.HOLDING), int(Mode.RUNNING), int(Mode.STOPPING)))
_ADVICE = {
    "position rate": "The arm cannot move that fast: check encoder, cable and shielding.",
    "position noise": "Check shielding and supply of the encoder, and its coupling.",
    "position stuck": "The reference moved and the count did not: check encoder, coupling, valve cable and shut-off valve.",
    "unexplained motion": "Command and motion disagree: check valve, its cable, polarity, supply and the encoder's coupling.",
}
_APART_ADVICE = "One of the two position sensors is wrong: compare both in the log; check couplings and calibrations."


def plausibility_checks(rig: Rig, facts: Facts) -> Iterator[Check]:
    """The checks of the section `interlocks.plausibility`, for every joint."""
    wanted = rig.interlocks.plausibility
    rules = (
        (wanted.rate, wanted.rate_reaction, "/s"),
        (wanted.noise, wanted.noise_reaction, ""),
        (wanted.stuck, wanted.stuck_reaction, ""),
        (wanted.flow, wanted.flow_reaction, ""),
    )
    for name, joint in rig.joints.items():
        signal = rig.signals[f"{name}.position"]
        source, age = f"{signal.device}.{signal.channel}", facts.index(f"{name}.position_age_s")
        unit = "rad" if joint.motion == "rotary" else "m"
        for (share, reaction, per), fact, (rule, advice) in zip(rules, PLAUSIBILITY_FACTS, _ADVICE.items(), strict=True):
            if share is None or (rule == "unexplained motion" and not rig.servo[name].velocity_feedforward):
                continue
            limit = share * (joint.rate_limit if per else joint.following_error_limit)
            index = facts.index(f"{name}.{fact}")
            yield Check(f"{name} {rule}", index, -inf, limit, unit + per, source, Reaction(reaction), advice, age)
        yield from _agreement(rig, facts, name, unit)


def _agreement(rig: Rig, facts: Facts, joint: str, unit: str) -> Iterator[Check]:
    """The two position sensors of a joint beside each other, where the rig file has both and a limit."""
    wanted, second = rig.interlocks.plausibility, rig.signals.get(f"{joint}.{SECOND_POSITION}")
    if wanted.apart is None or second is None:
        return
    limit, index = wanted.apart * rig.joints[joint].following_error_limit, facts.index(f"{joint}.{APART_FACT}")
    source, age = f"{second.device}.{second.channel}", facts.index(f"{joint}.{SECOND_POSITION}_age_s")
    yield Check(f"{joint} positions apart", index, -inf, limit, unit, source, Reaction(wanted.apart_reaction), _APART_ADVICE, age)


class Plausibility:
    """All joints. `update` belongs between reading and checking; plain floats, nothing that grows."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        self._mode = facts.index("mode")
        period_s = 1.0 / rig.loop.rate_Hz
        self._joints = tuple(_PositionWatch(rig, facts, name, period_s) for name in rig.joints)
        twice = [joint for joint in rig.joints if f"{joint}.{SECOND_POSITION}" in rig.signals]
        columns = ("position", SECOND_POSITION, APART_FACT)
        self._twice = tuple(tuple(facts.index(f"{joint}.{column}") for column in columns) for joint in twice)

    def update(self, values: list[float], now_ns: int) -> None:
        servo_acts = int(values[self._mode]) in _SERVO_ACTS
        now_s = now_ns * 1e-9
        for joint in self._joints:
            joint.update(values, now_s, servo_acts)
        for first, second, apart in self._twice:
            difference = abs(values[first] - values[second])
            if difference == difference:  # a BAD sample (NaN) is for the quality check
                values[apart] = difference


class _PositionWatch:
    """One joint. Time between samples counts in whole periods: jitter of the loop is not motion."""

    def __init__(self, rig: Rig, facts: Facts, joint: str, period_s: float) -> None:
        at = facts.index
        self._at_position, self._at_raw, self._at_age = at(f"{joint}.position"), at(f"{joint}.position_raw"), at(f"{joint}.position_age_s")
        self._at_reference, self._at_command = at(f"{joint}.reference"), at(f"{joint}.command_V")
        self._rate, self._noise, self._stuck, self._flow = (at(f"{joint}.{fact}") for fact in PLAUSIBILITY_FACTS)
        servo = rig.servo[joint]
        self._rate_per_V = 1.0 / servo.velocity_feedforward if servo.velocity_feedforward else 0.0
        self._null_bias_V = servo.null_bias_V
        self._period_s = period_s
        self._forget_noise = 1.0 - exp(-1.0 / NOISE_CYCLES)
        self._position = self._raw = self._velocity = self._reference = nan
        self._stamp_s = self._unexplained = 0.0

    def update(self, values: list[float], now_s: float, servo_acts: bool) -> None:
        """One cycle. A BAD sample (NaN) is for the quality check; the next good one is compared with the last good one."""
        position, stamp_s = values[self._at_position], now_s - values[self._at_age]
        self._follow_reference(values, servo_acts)
        if not (isfinite(position) and isfinite(stamp_s)):
            return
        periods = round((stamp_s - self._stamp_s) / self._period_s)
        if periods < 1:
            return
        moved, elapsed_s = position - self._position, periods * self._period_s
        self._position, self._stamp_s = position, stamp_s
        if moved != moved:  # the first sample
            return
        velocity = moved / elapsed_s
        values[self._rate] = abs(velocity)
        if periods == 1 and self._velocity == self._velocity:
            odd = abs(velocity - self._velocity) * self._period_s
            values[self._noise] += self._forget_noise * (odd - values[self._noise])
        self._velocity = velocity if periods == 1 else nan
        self._compare_with_command(values, moved, elapsed_s, servo_acts)

    def _follow_reference(self, values: list[float], servo_acts: bool) -> None:
        """How far the reference is from where it was when the count last changed."""
        reference, raw = values[self._at_reference], values[self._at_raw]
        if raw != self._raw or not servo_acts:
            self._raw, self._reference = raw, reference
        values[self._stuck] = abs(reference - self._reference)

    def _compare_with_command(self, values: list[float], moved: float, elapsed_s: float, servo_acts: bool) -> None:
        if not servo_acts or elapsed_s > LONGEST_HOLD_S:
            self._unexplained = 0.0
        else:
            keep = exp(-elapsed_s / FLOW_MEMORY_S)
            expected = self._rate_per_V * (values[self._at_command] - self._null_bias_V) * elapsed_s
            self._unexplained = keep * self._unexplained + expected - moved
        values[self._flow] = abs(self._unexplained)
