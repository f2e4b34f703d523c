"""Whether a measured position is one the joint can have: rate (a jump), noise, stuck, and motion that the command does not explain; and
whether a second sensor of the motion, where there is one, agrees.

Four numbers a joint and that difference, renewed in every cycle with a new sample and checked like any other fact. They use the reference
and the command of the last cycle, which is what the sample answers to. Nothing here is logged: the log's own columns give the same
numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from math import exp, inf, isfinite, nan

from config.schema.rig import Rig
from config.signal_names import SECOND_POSITION
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, DeclaredFact, Family, Limits, Stage, Subject, joint_subject, source_of
from daemon.cycle.facts import Facts
from servo_control.signals import SERVO_ACTS

RATE, NOISE, STUCK, FLOW, APART = "position_rate", "position_noise", "stuck_motion", "unexplained_motion", "positions_apart"
NOISE_CYCLES = 10.0  # time constant of the mean: a single odd sample is not noise
FLOW_MEMORY_S = 0.1  # longer than valve and oil need to follow the command (about 10 ms)
LONGEST_HOLD_S = 0.05  # a command that was not renewed for longer may have been ended by the device's own time-out


def _subjects(rig: Rig) -> list[Subject]:
    """`second`: device and channel of the second position sensor, where the joint has one."""
    twice = {joint: f"{joint}.{SECOND_POSITION}" for joint in rig.joints}
    return [
        {**joint_subject(rig, joint), **({"second": source_of(rig, name)} if name in rig.signals else {})} for joint, name in twice.items()
    ]


def _at_most(share: Callable[[Rig, Subject], float | None], of_rate: bool = False) -> Callable[[Rig, Subject], Limits | None]:
    """Limits from a share of the joint's following error limit, or of its rate limit."""

    def limits(rig: Rig, subject: Subject) -> Limits | None:
        joint, wanted = rig.joints[subject["joint"]], share(rig, subject)
        return None if wanted is None else (-inf, wanted * (joint.rate_limit if of_rate else joint.following_error_limit))

    return limits


def _flow(rig: Rig, subject: Subject) -> float | None:
    """Needs the rate a volt gives."""
    return rig.interlocks.plausibility.flow if rig.servo[subject["joint"]].velocity_feedforward else None


def _apart(rig: Rig, subject: Subject) -> float | None:
    return rig.interlocks.plausibility.apart if "second" in subject else None


def _reaction(key: str) -> Callable[[Rig, Subject], Reaction]:
    return lambda rig, subject: Reaction(getattr(rig.interlocks.plausibility, f"{key}_reaction"))


def _reaction_from(key: str) -> str:
    return f"that of `interlocks.plausibility.{key}_reaction`"


class PlausibilityWatch:
    """All joints. `update` belongs between reading and checking."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        self._mode = facts.index("mode")
        period_s = 1.0 / rig.loop.rate_Hz
        self._joints = tuple(_PositionWatch(rig, facts, name, period_s) for name in rig.joints)
        twice = [joint for joint in rig.joints if f"{joint}.{SECOND_POSITION}" in rig.signals]
        columns = ("position", SECOND_POSITION, APART)
        self._twice = tuple(tuple(facts.index(f"{joint}.{column}") for column in columns) for joint in twice)

    def update(self, values: list[float], now_ns: int, unix_ns: int) -> None:
        servo_acts = int(values[self._mode]) in SERVO_ACTS
        now_s = now_ns * 1e-9
        for joint in self._joints:
            joint.update(values, now_s, servo_acts)
        for first, second, apart in self._twice:
            values[apart] = abs(values[first] - values[second])  # NaN, which no check passes, where either is not known


class _PositionWatch:
    """One joint. Time between samples counts in whole periods: jitter of the loop is not motion."""

    def __init__(self, rig: Rig, facts: Facts, joint: str, period_s: float) -> None:
        at = facts.index
        self._at_position, self._at_raw, self._at_age = at(f"{joint}.position"), at(f"{joint}.position_raw"), at(f"{joint}.position_age_s")
        self._at_reference, self._at_command = at(f"{joint}.reference"), at(f"{joint}.command_V")
        self._rate, self._noise, self._stuck, self._flow = (at(f"{joint}.{fact}") for fact in (RATE, NOISE, STUCK, FLOW))
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


_AGE, _UNIT = "{joint}.position_age_s", "{unit}"

POSITION_RATE = Declaration(
    name="{joint} position rate",
    fact="{joint}." + RATE,
    meaning="size of the change of position from one sample to the next, over the whole periods between them",
    unit=_UNIT + "/s",
    limits=_at_most(lambda rig, subject: rig.interlocks.plausibility.rate, of_rate=True),
    limit_from="at most `interlocks.plausibility.rate` times `joints.NAME.rate_limit`",
    source="{source}",
    reaction=_reaction("rate"),
    reaction_from=_reaction_from("rate"),
    advice="The arm cannot move that fast: check encoder, cable and shielding. Then `longreach reset`.",
    age=_AGE,
)
POSITION_NOISE = Declaration(
    name="{joint} position noise",
    fact="{joint}." + NOISE,
    meaning=f"mean deviation from uniform motion from one sample to the next (time constant {NOISE_CYCLES:g} cycles)",
    unit=_UNIT,
    limits=_at_most(lambda rig, subject: rig.interlocks.plausibility.noise),
    limit_from="at most `interlocks.plausibility.noise` times `joints.NAME.following_error_limit`",
    source="{source}",
    reaction=_reaction("noise"),
    reaction_from=_reaction_from("noise"),
    advice="Check shielding and supply of the encoder, and its coupling. Then `longreach reset`.",
    age=_AGE,
)
POSITION_STUCK = Declaration(
    name="{joint} position stuck",
    fact="{joint}." + STUCK,
    meaning="how far the reference is from where it was when the count last changed, while the servo acts",
    unit=_UNIT,
    limits=_at_most(lambda rig, subject: rig.interlocks.plausibility.stuck),
    limit_from="at most `interlocks.plausibility.stuck` times `joints.NAME.following_error_limit`",
    source="{source}",
    reaction=_reaction("stuck"),
    reaction_from=_reaction_from("stuck"),
    advice="The reference moved and the count did not: check encoder, coupling, valve cable and shut-off valve. Then `longreach reset`.",
    age=_AGE,
)
UNEXPLAINED_MOTION = Declaration(
    name="{joint} unexplained motion",
    fact="{joint}." + FLOW,
    meaning=f"command / `velocity_feedforward` less the measured rate, summed with a memory of {FLOW_MEMORY_S:g} s, while the servo acts",
    unit=_UNIT,
    limits=_at_most(_flow),
    limit_from="at most `interlocks.plausibility.flow` times `joints.NAME.following_error_limit`",
    source="{source}",
    reaction=_reaction("flow"),
    reaction_from=_reaction_from("flow"),
    advice="Command and motion disagree: check valve, its cable, polarity, supply and the encoder's coupling. Then `longreach reset`.",
    age=_AGE,
)
POSITIONS_APART = Declaration(
    name="{joint} positions apart",
    fact="{joint}." + APART,
    meaning="difference of the joint's two position sensors",
    unit=_UNIT,
    limits=_at_most(_apart),
    limit_from="at most `interlocks.plausibility.apart` times `joints.NAME.following_error_limit`",
    source="{second}",
    reaction=_reaction("apart"),
    reaction_from=_reaction_from("apart"),
    advice="One of the two position sensors is wrong: compare both in the log; check couplings and calibrations. Then `longreach reset`.",
    age="{joint}." + SECOND_POSITION + "_age_s",
)

FAMILIES = (
    Family(
        "Positions that the joint cannot have",
        Stage.PLAUSIBILITY,
        _subjects,
        (POSITION_RATE, POSITION_NOISE, POSITION_STUCK, UNEXPLAINED_MOTION, POSITIONS_APART),
        facts=tuple(DeclaredFact(f"{{joint}}.{name}", blank=0.0) for name in (RATE, NOISE, STUCK, FLOW, APART)),
        watch=PlausibilityWatch,
        from_log=True,
    ),
)
