"""What ends a run that is driven by hand: set points that stay away, come late, or ask for what cannot be; and a client that is gone."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, DeclaredFact, Family, Stage, the_daemon
from servo_control.numerics.limits import ROUNDING

SOURCE = "who drives by hand"
AGAIN = "When that is put right: `longreach jog`."

Limit = tuple[Callable[[Rig], float], str]  # the most that passes, and where that is from


def _at_most(number: float) -> Limit:
    return lambda rig: number, f"{number:g}"


TIMEOUT: Limit = (lambda rig: rig.loop.set_point_timeout_s, "`loop.set_point_timeout`")


def _declared(name: str, fact: str, meaning: str, unit: str, limit: Limit, advice: str) -> Declaration:
    most, limit_from = limit
    return Declaration(
        name=name,
        fact=fact,
        meaning=meaning,
        unit=unit,
        limits=lambda rig, subject: (-inf, most(rig)),
        limit_from=f"at most {limit_from}",
        source=SOURCE,
        reaction=Reaction.STOP,
        advice=f"{advice} {AGAIN}",
    )


CLIENT = _declared(
    "driving client",
    "driving.client_left",
    "1 when the connection that drives has been closed without an end of the run",
    "",
    _at_most(0.0),
    "The program that drove has ended or its connection was cut.",
)
UNUSABLE = _declared(
    "set point usable",
    "driving.unusable",
    "numbers of the run's set points that are not finite, or none at all",
    "numbers",
    _at_most(0.0),
    "The program that drives sends NaN, infinity or no numbers.",
)
REACH = _declared(
    "set point in range",
    "driving.reach",
    "largest share of its limit that a set point of the run has asked for: `joints.NAME.rate_limit`, `joints.NAME.travel`"
    " (of a position as far as the middle of the travel is from its end), or of the tip's speed with both joints at their limits",
    "of the limit",
    _at_most(ROUNDING),
    "The program that drives asks for more than the rig file allows; the answer to `stream` names the limits.",
)
LATE = _declared(
    "set point in time",
    "driving.late_s",
    "how much longer a set point of the run was on its way than the quickest one, by the client's clock (`t_s`)",
    "s",
    TIMEOUT,
    "The network or the program holds set points up.",
)
SILENT = _declared(
    "set points arriving",
    "driving.silent_s",
    "time since the last usable set point of a run that is driven by hand",
    "s",
    TIMEOUT,
    "The program that drives has stopped sending, or the network between stands still.",
)

CHECKS = (CLIENT, UNUSABLE, REACH, LATE, SILENT)
FACTS = ("driving.silent_s", "driving.late_s", "driving.unusable", "driving.reach", "driving.client_left")  # as signals.Driving has them
FAMILIES = (Family("Driving by hand", Stage.BY_HAND, the_daemon, CHECKS, facts=tuple(DeclaredFact(fact, 0.0) for fact in FACTS)),)
