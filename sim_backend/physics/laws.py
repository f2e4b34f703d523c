"""Laws that effects bring along: at a hook of the kernel, what all other physics gives passes through every such law in turn.

An effect with a law has a block at the end of the parameter vector for every joint (sensor, supply, link): whether it is there (1, else 0),
then its parameters. Without such effects the vector ends where `layout` says, and the hooks compile to nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

from numba import float64
from numba.core.errors import NumbaError

from config.errors import PlantError
from config.schema.effect import BESIDE, Hook, Law
from config.schema.effect_library import EFFECTS
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import J_START, J_STRIDE, MAX_SENSORS, PARAMETERS, SLOTS, Vector

Hooked = Callable[[float, tuple[float, ...], int, Vector], float]


@dataclass(frozen=True, slots=True)
class LawBlock:
    """Where one effect's law finds its numbers: `start + place * width` for each joint slot or sensor; supply and link are one place."""

    effect: str
    start: int
    parameters: tuple[str, ...]
    places: int

    @property
    def width(self) -> int:
        return 1 + len(self.parameters)

    @property
    def end(self) -> int:
        return self.start + self.width * self.places


_PLACES = {Hook.SUPPLY: 1, Hook.BENDING: 1, Hook.READING: MAX_SENSORS}  # at the other hooks one a joint slot


def _blocks() -> Iterator[LawBlock]:
    at = PARAMETERS
    for name, effect in EFFECTS.items():
        if effect.law:
            block = LawBlock(name, at, effect.law.parameters, _PLACES.get(effect.law.hook, SLOTS))
            yield block
            at = block.end


BLOCKS = {block.effect: block for block in _blocks()}
LAWS = frozenset(effect.law.hook for effect in EFFECTS.values() if effect.law)  # hooks at which there is any
END = max((block.end for block in BLOCKS.values()), default=PARAMETERS)  # length of the parameter vector


@cache
def block_names() -> tuple[str, ...]:
    """A name for every entry of the vector beyond `layout.parameter_names`: `hose_swelling0.present`, `hose_swelling0.swelling`."""
    return tuple(f"{b.effect}{place}.{word}" for b in BLOCKS.values() for place in range(b.places) for word in ("present", *b.parameters))


@compiled
def slot_of(j: int) -> int:
    """The slot of a joint from the start of its parameters."""
    return (j - J_START) // J_STRIDE


@compiled
def _unchanged(value: float, state: tuple[float, ...], place: int, p: Vector) -> float:
    return value


@compiled
def _one(p: Vector, at: int) -> tuple[float]:
    return (p[at],)


@compiled
def _two(p: Vector, at: int) -> tuple[float, float]:
    return p[at], p[at + 1]


@compiled
def _three(p: Vector, at: int) -> tuple[float, float, float]:
    return p[at], p[at + 1], p[at + 2]


@compiled
def _four(p: Vector, at: int) -> tuple[float, float, float, float]:
    return p[at], p[at + 1], p[at + 2], p[at + 3]


_TAKEN: tuple[Any, ...] = (_one, _two, _three, _four)  # numba wants the length of a tuple when it compiles


def hooked(hook: Hook) -> Hooked:
    """What the kernel calls at a hook: `(value, the hook's other numbers, slot, sensor or 0, parameters) -> value`."""
    through: Hooked = _unchanged
    for name, effect in EFFECTS.items():
        if effect.law and effect.law.hook is hook:
            through = _then(through, _compiled(name, effect.law), BLOCKS[name])
    return through


def _compiled(effect: str, law: Law) -> Callable[..., float]:
    """The law as the kernel calls it; PlantError when it is not what the kernel can compile."""
    function = compiled(law.function)
    try:
        function.compile((float64,) * (1 + len(BESIDE[law.hook]) + len(law.parameters)))  # type: ignore[attr-defined]
    except NumbaError as error:
        what = f"the law of the effect {effect} cannot be compiled: {str(error).strip().splitlines()[0]}"
        advice = "Use plain arithmetic and the module math on numbers, or uninstall the library that brings it."
        raise PlantError(what, where=law.function.__code__.co_filename, next_step=advice) from error
    return function


def _then(before: Hooked, law: Callable[..., float], block: LawBlock) -> Hooked:
    start, width, taken = block.start, block.width, _TAKEN[len(block.parameters) - 1]

    @compiled
    def after(value: float, state: tuple[float, ...], place: int, p: Vector) -> float:
        value = before(value, state, place, p)
        at = start + place * width
        if p[at] == 0.0:
            return value
        return float(law(value, *(state + taken(p, at + 1))))

    return after
