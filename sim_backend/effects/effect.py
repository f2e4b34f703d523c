"""What the simulation knows about one physical effect. The entry's class in config holds parameters, units and ranges."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from config.effect_entry import EffectEntry


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
class Effect:
    """One physical effect: how it enters the parameter vector, and how it shows itself in measurements."""

    entry: type[EffectEntry]
    writes: tuple[Write, ...]
    neutral: Mapping[str, float]  # parameters (by their name in the file) whose value (of a list: each) makes the effect vanish
    fingerprint: str  # what it looks like in a log, one sentence
    look_alikes: Mapping[str, str]  # effect with similar traces → what separates the two
