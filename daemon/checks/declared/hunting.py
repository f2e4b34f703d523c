"""A servo that shakes its joint with all it has: the command goes from one of its limits to the other and back.

Moves are planned within the rate limit and need no full valve, a joint that is held up asks for one side alone, and an excitation is
seldom at both limits. What is there for long on both sides is an unstable loop: too much gain, oil that is too warm, air, play.
"""

from __future__ import annotations

from math import exp, inf

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, DeclaredFact, Family, Stage, joint_subject
from daemon.cycle.facts import Facts
from servo_control.signals import SERVO_ACTS

HUNTING = "hunting"
MEAN_S = 1.0  # some periods of a joint on its oil, which are 10 to 300 ms
MOST = 0.5
_FULL = 0.98  # of the limit


class HuntingWatch:
    """Of every joint the share of the time at either limit, as means that forget exponentially; the rarer one counts, twice."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        at = facts.index
        self._mode, self._forget = at("mode"), 1.0 - exp(-1.0 / (rig.loop.rate_Hz * MEAN_S))
        self._joints = [
            (at(f"{name}.command_V"), at(f"{name}.{HUNTING}"), _FULL * joint.command_limit_V) for name, joint in rig.joints.items()
        ]
        self._shares = [(0.0, 0.0) for _ in self._joints]

    def update(self, values: list[float], now_ns: int, unix_ns: int) -> None:
        if int(values[self._mode]) not in SERVO_ACTS:
            self._shares = [(0.0, 0.0) for _ in self._joints]
        for number, (command, fact, full_V) in enumerate(self._joints):
            up, down = self._shares[number]
            up += self._forget * ((values[command] >= full_V) - up)
            down += self._forget * ((values[command] <= -full_V) - down)
            self._shares[number] = up, down
            values[fact] = 2.0 * min(up, down)


SERVO_HUNTING = Declaration(
    name="{joint} hunting",
    fact="{joint}." + HUNTING,
    meaning=f"twice the share of the last {MEAN_S:g} s in which the command was at the rarer one of its two limits",
    unit="",
    limits=lambda rig, subject: (-inf, MOST),
    limit_from=f"at most {MOST:g}",
    source="joint {joint}",
    reaction=Reaction.FAULT,
    advice="The servo is unstable: lower `servo.{joint}.gain`; `longreach check` says how far. Then `longreach reset`.",
)

FAMILIES = (
    Family(
        "A servo that shakes its joint",
        Stage.MOTION,
        lambda rig: [joint_subject(rig, joint) for joint in rig.joints],
        (SERVO_HUNTING,),
        facts=(DeclaredFact(f"{{joint}}.{HUNTING}", blank=0.0),),
        watch=HuntingWatch,
        from_log=True,
    ),
)
