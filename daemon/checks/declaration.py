"""A check as it is declared, once for all rigs: the fact it reads, its limit and where that comes from, what its failure does, and advice.

The loop, `longreach why`, docs/reference/checks.md and the tests are made from these declarations. A text may hold names in braces that
the subject fills in: "{signal} age" becomes "rotary.position age", and "SIGNAL age" in the reference.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from math import inf, nan
from typing import Protocol

from config.schema.rig import Rig
from config.schema.signals import Signal
from daemon.checks.checks import Check, Reaction
from daemon.cycle.facts import Facts
from recording.format.fields import field_of_signal

REFERENCE_PAGE = "docs/reference/checks.md"

Subject = Mapping[str, str]  # names for the braces: one signal, joint or device of a rig; empty for the daemon itself
Limits = tuple[float, float]  # lowest and highest number that passes, in the check's unit


class Stage(IntEnum):
    """Causes before their consequences: of several failed checks with one reaction, the first is named."""

    DAEMON = 1
    PROOF = 2
    CALIBRATION = 3
    SENSOR = 4
    PLAUSIBILITY = 5
    OIL = 6
    MOTION = 7
    REST = 8
    BY_HAND = 9


class Purpose(Enum):
    """What is refused while a check fails, and meets its reaction when under way."""

    ARMED = "arming"
    PROOF = "the proof of the safe state"
    REST = "a start with `--settle`"


@dataclass(frozen=True, slots=True)
class DeclaredFact:
    """A number that only checks need, one for each subject. `blank`: before anything was measured."""

    name: str
    blank: float = nan


@dataclass(frozen=True, slots=True)
class Declaration:
    """One check of every subject for which `limits` gives a pair. `fact`, `age`: names of facts; `limit_from`: keys of the rig file."""

    name: str
    fact: str
    meaning: str
    unit: str
    limits: Callable[[Rig, Subject], Limits | None]
    limit_from: str
    source: str
    reaction: Reaction | Callable[[Rig, Subject], Reaction]
    advice: str
    age: str = ""
    reaction_from: str = ""  # the key of the rig file that chooses the reaction, as a text of the reference
    purposes: tuple[Purpose, ...] = (Purpose.ARMED,)

    @property
    def title(self) -> str:
        """The name for all subjects: "SIGNAL age"."""
        return for_all(self.name)

    @property
    def anchor(self) -> str:
        """Of the heading in the reference, as GitHub makes it from the title."""
        return re.sub(r"[^\w -]", "", self.title.lower()).replace(" ", "-")

    def check(self, rig: Rig, subject: Subject, facts: Facts) -> Check | None:
        """The check of one subject; None where the rig file sets no limit."""
        limits = self.limits(rig, subject)
        if limits is None or limits == (-inf, inf):
            return None
        return Check(
            name=self.name.format_map(subject),
            index=facts.index(self.fact.format_map(subject)),
            low=limits[0],
            high=limits[1],
            unit=self.unit.format_map(subject),
            source=self.source.format_map(subject),
            reaction=self.reaction if isinstance(self.reaction, Reaction) else self.reaction(rig, subject),
            next_step=self.advice.format_map(subject),
            age_index=facts.index(self.age.format_map(subject)) if self.age else None,
            page=f"{REFERENCE_PAGE}#{self.anchor}",
        )


class FactWatch(Protocol):
    """Computes the facts of a family."""

    def update(self, values: list[float], now_ns: int, unix_ns: int) -> None:
        """Once a cycle: plain floats, nothing that grows. `now_ns` of the monotonic clock; `unix_ns` as the log stamps the cycle."""


@dataclass(frozen=True, slots=True)
class Family:
    """Checks over the same subjects, with the facts only they need and what computes these.

    `spare`: the facts may wait until the outputs are written. `from_log`: they follow from the log's columns and times alone.
    """

    about: str
    stage: Stage
    subjects: Callable[[Rig], Iterable[Subject]]
    checks: tuple[Declaration, ...]
    facts: tuple[DeclaredFact, ...] = ()
    watch: Callable[[Rig, Facts], FactWatch] | None = None
    spare: bool = False
    from_log: bool = False


def for_all(text: str) -> str:
    """A text with its braces filled in for all subjects at once: "{signal} age" → "SIGNAL age"."""
    return re.sub(r"\{(\w+)\}", lambda match: match[1].upper(), text)


def the_daemon(rig: Rig) -> tuple[Subject, ...]:
    """The subject of checks that every rig has once."""
    return ({},)


def source_of(rig: Rig, signal: str) -> str:
    """Device and channel of a signal."""
    return f"{rig.signals[signal].device}.{rig.signals[signal].channel}"


def measured(rig: Rig, signal: str) -> tuple[Subject, ...]:
    """The signal with this name as a subject, where the rig has it."""
    return (signal_subject(rig, signal),) if signal in rig.signals else ()


def signal_subject(rig: Rig, name: str) -> Subject:
    """`field` holds its engineering value in the facts, in `unit`."""
    unit = _UNITS[rig.signals[name].measures]
    return {"signal": name, "source": source_of(rig, name), "field": field_of_signal(name), "unit": unit}


def joint_subject(rig: Rig, joint: str) -> Subject:
    """`unit` is rad or m, `source` that of its position."""
    return {"joint": joint, "source": source_of(rig, f"{joint}.position"), "unit": rig.joints[joint].position_unit}


def open_limits(low: float | None, high: float | None) -> Limits:
    """An absent limit is none."""
    return (-inf if low is None else low, inf if high is None else high)


AGE_LIMIT_FROM = "at most `signals.NAME.max_age`, either way: a stamp of another clock lies ahead"


def age_limits(signal: Signal) -> Limits:
    """Either way: a stamp of another clock lies ahead, and would be fresh for ever."""
    return (-signal.max_age_s, signal.max_age_s)


_UNITS = {"angle": "rad", "length": "m", "pressure": "Pa", "temperature": "degC", "acceleration": "m/s^2"}
