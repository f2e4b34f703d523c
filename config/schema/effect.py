"""What the file of one physical effect declares. Whatever else knows effects (schema, kernel, search, report, tests) reads it from here.

An effect's file holds the class of its entry in a rig file (parameters with units and ranges) and `EFFECT = Effect(...)`.
`effect_library` finds the files.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum, StrEnum
from typing import Any

from config.errors import ConfigError
from config.schema.effect_entry import EffectEntry, JointEntry, LinkEntry, SensorEntry, SupplyEntry
from config.schema.section import yaml_key

LAST = 1000.0  # place in every list of an effect that does not say one


class Equation(StrEnum):
    """The balance of the plant that an effect enters."""

    FORCE = "force balance"
    VALVE = "valve command to spool"
    FLOW = "chamber flow balance"
    SUPPLY = "supply"
    LINK = "link bending"
    SENSOR = "sensor"


class Hook(StrEnum):
    """Where in the kernel a law acts: the value that passes through it (SI)."""

    SPOOL_COMMAND = "spool command"  # share of the full opening, before hysteresis and saturation
    COMPLIANCE = "chamber compliance"  # of hoses and structure, 1/Pa
    LEAKAGE = "leakage"  # from chamber A to B, m³/s
    FRICTION = "sliding friction"  # N or N m, never below 0
    FORCE = "force on the load"  # N or N m, in the joint's positive direction
    SUPPLY = "supply pressure"  # at a valve, Pa
    BENDING = "bending force"  # on the tip's deflection, N: elastic, damping and Coriolis; pushes no joint by itself
    READING = "reading"  # of a sensor, in its signal's unit, before it is rounded


BESIDE: Mapping[Hook, tuple[str, ...]] = {  # what else a law gets at each hook
    Hook.SPOOL_COMMAND: ("command_V",),
    Hook.COMPLIANCE: ("gauge_Pa",),
    Hook.LEAKAGE: ("a_Pa", "b_Pa"),
    Hook.FRICTION: ("velocity", "a_minus_b_Pa"),
    Hook.FORCE: ("position", "velocity"),
    Hook.SUPPLY: ("flow_m3_per_s",),  # that this valve takes, lagged by its hose
    Hook.BENDING: ("deflection_m", "deflection_rate_m_per_s", "extension_m"),
    Hook.READING: ("true_value",),
}
ENTRY_AT: Mapping[Hook, type[EffectEntry]] = {  # of an effect with a law there; at the other hooks a joint's
    Hook.SUPPLY: SupplyEntry,
    Hook.BENDING: LinkEntry,
    Hook.READING: SensorEntry,
}
VARIABLES = ("velocity", "acceleration", "position", "command_V", "command_rate", "reading")


@dataclass(frozen=True, slots=True)
class Write:
    """One parameter of an effect → one entry of the parameter vector, or of a list as many as it has, from `index` on.

    `added`: on top of the base plant's value instead of in its place; `convert`: from the file's value to the vector's.
    """

    parameter: str
    index: IntEnum  # C for the whole plant, J at a joint, S at a sensor
    added: bool = False
    convert: Callable[[Any], float | tuple[float, ...]] = float


@dataclass(frozen=True, slots=True)
class Law:
    """A law that the kernel does not have: it acts at one of the kernel's hooks, on what all other physics gives there.

    `function(value, …what the hook has beside it, …parameters) -> value`: plain arithmetic and `math` on floats, because the kernel
    compiles it. It is not called where the effect is absent or neutral.
    `parameters`: keys of the entry, one to four, in the function's order.
    """

    hook: Hook
    function: Callable[..., float]
    parameters: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Sizes:
    """What is large for one place of a rig, in SI: the yardsticks of plausible effects."""

    force: float = 1.0  # of the actuator at full supply pressure or full command
    velocity: float = 1.0  # the joint's rate limit
    mass: float = 1.0
    length: float = 1.0  # 1 m, or 1 rad
    area: float = 1.0
    pressure: float = 1e7
    slow: float = 0.01  # velocity at which friction's micro-damping has faded
    stiffness: float = 1.0
    payload: float = 10.0
    bending: float = 1000.0
    noise: float = 1e-6  # of the sensor
    span: float = 1.0  # of the sensor's range


Size = Callable[[Sizes], float]


@dataclass(frozen=True, slots=True)
class Freedom:
    """One parameter that the search fits: typical size, plausible range, and the sizes (in typical ones) from which fits start.

    `beside`: it is fitted only where this effect is present, because it is a difference of what that one has.
    """

    parameter: str
    typical: Size
    low: Size
    high: Size
    starts: tuple[float, ...] = (1.0,)
    beside: str = ""


def up(parameter: str, typical: Size, most: float, starts: tuple[float, ...] = (1.0,)) -> Freedom:
    """A parameter that is never negative, up to `most` typical sizes."""
    return Freedom(parameter, typical, lambda _: 0.0, lambda s: most * typical(s), starts)


def both(parameter: str, typical: Size, most: float, beside: str = "") -> Freedom:
    """A parameter of either sign."""
    return Freedom(parameter, typical, lambda s: -most * typical(s), lambda s: most * typical(s), (1.0, -1.0), beside)


@dataclass(frozen=True, slots=True)
class Search:
    """How `longreach gap` looks for the effect: the balance it enters, its free parameters, its fixed ones, and where it is sought."""

    equation: Equation
    free: tuple[Freedom, ...]
    fixed: Mapping[str, Callable[[Sizes], float]] = field(default_factory=dict)
    beside: str = ""  # only where this effect is present
    at_held_rod: bool = False  # also at a rod that a testing machine presses into a chamber: its seal and its mass
    except_at: tuple[str, ...] = ()  # signals at which a constant of the rig file says the same
    smaller_is_weaker: bool = True  # a smaller first parameter is a smaller effect


@dataclass(frozen=True, slots=True)
class Case:
    """For the tests: the effect on the shipped testbed with these values must change this signal, and with its neutral value nothing."""

    where: str
    values: Mapping[str, Any]  # keys and values as in a rig file
    signal: str


@dataclass(frozen=True, slots=True)
class Effect:
    """One physical effect: its entry in a rig file, how it enters the simulation, how it shows in measurements, how it is searched.

    Parameters go by their keys in the file (`tilt`, not `tilt_rad`). Each goes either to an entry of the parameter vector that the kernel
    reads (`writes`) or to a law of its own (`law`).
    Raises ConfigError where the parts do not fit together.
    """

    entry: type[EffectEntry]
    neutral: Mapping[str, float]  # parameters (keys) whose value (of a list: each) makes the effect vanish
    fingerprint: str  # what it looks like in a log, one sentence
    look_alikes: Mapping[str, str]  # effect with similar traces → what separates the two
    cases: tuple[Case, ...]
    writes: tuple[Write, ...] = ()
    law: Law | None = None
    variable: str = "velocity"  # one of VARIABLES: against which what it leaves shows its shape
    search: Search | None = None  # None: simulated, never looked for
    order: float = LAST  # place in every list of effects

    def __post_init__(self) -> None:
        own = self.fields.keys() - {"effect", "where", "quantity_kind"}
        law = self.law.parameters if self.law else ()
        sought = [*(f.parameter for f in self.search.free), *self.search.fixed] if self.search else []
        written = [w.parameter for w in self.writes]
        for part, named in (("writes", written), ("law", law), ("neutral", self.neutral), ("search", sought)):
            for wrong in set(named) - own:
                raise self._error(f"{part} names {wrong!r}, which is no parameter of its entry", limit=", ".join(sorted(own)))
        for idle in own - set(written) - set(law):
            raise self._error(f"its parameter {idle!r} goes nowhere", next_step="Name it in `writes` or in `law`.")
        if not self.neutral:
            raise self._error("it has no neutral value", next_step="Say at which value of which parameter it vanishes.")
        if self.variable not in VARIABLES:
            raise self._error("its variable is none", value=self.variable, limit=", ".join(VARIABLES))
        if self.law:
            self._check_law(self.law)

    def _check_law(self, law: Law) -> None:
        if not 1 <= len(law.parameters) <= 4:
            raise self._error("a law has one to four parameters", value=len(law.parameters))
        at = ENTRY_AT.get(law.hook, JointEntry)
        if not issubclass(self.entry, at):
            raise self._error(f"the hook {law.hook.value!r} is at {at.place}")
        wanted = ("value", *BESIDE[law.hook], *law.parameters)
        takes = inspect.signature(law.function)
        if len(takes.parameters) != len(wanted):
            raise self._error(f"its law at the hook {law.hook.value!r} takes ({', '.join(wanted)})", value=str(takes))

    @property
    def name(self) -> str:
        """The word after `effect:` that chooses it."""
        return str(self.entry.model_fields["effect"].annotation.__args__[0])  # type: ignore[union-attr]

    @property
    def fields(self) -> dict[str, str]:
        """Key in the file → name of the entry's field."""
        return {yaml_key(name): name for name in self.entry.model_fields}

    @property
    def is_of_the_whole_plant(self) -> bool:
        """Whether it sets numbers that the plant has once: a second entry, wherever it stands, would overwrite the first."""
        return any(type(write.index).__name__ == "C" and not write.added for write in self.writes)

    def is_neutral(self, entry: EffectEntry) -> bool:
        """Whether the entry's values make the effect vanish."""
        given = entry.model_dump(by_alias=True)
        return all(given[key] == value for key, value in self.neutral.items())

    def _error(self, what: str, **parts: Any) -> ConfigError:
        return ConfigError(f"effect {self.name}: {what}", where=inspect.getfile(self.entry), **parts)
