"""What every command shaper is: targets in, references out, once a cycle, for all joints at once.

A shaper reaches rest `flush_s` after its input came to rest. It is reset where a run starts, so it never jumps.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

Snapshot = dict[str, Any]


class Shaper(Protocol):
    """`step` reads target and target rate and overwrites reference and reference rate (rad or m, in the order of the joints)."""

    flush_s: float

    def reset(self, target: Sequence[float]) -> None:
        """As if the target had been at rest at `target` for ever."""

    def step(self, target: Sequence[float], target_rate: Sequence[float], reference: list[float], reference_rate: list[float]) -> None:
        """One cycle."""

    def snapshot(self) -> Snapshot:
        """The whole state, JSON-able and exact."""

    def restore(self, state: Snapshot) -> None:
        """The inverse of snapshot, on a shaper made from the same set-up."""


class NoShaper:
    """The reference is the target."""

    __slots__ = ("flush_s",)

    def __init__(self) -> None:
        self.flush_s = 0.0

    def reset(self, target: Sequence[float]) -> None:
        return None

    def step(self, target: Sequence[float], target_rate: Sequence[float], reference: list[float], reference_rate: list[float]) -> None:
        reference[:] = target
        reference_rate[:] = target_rate

    def snapshot(self) -> Snapshot:
        return {}

    def restore(self, state: Snapshot) -> None:
        return None
