"""The entry `unnamed_remainder`: a force on a joint (or friction) as a table over one variable, where nobody knows the physics.

No physics itself. Between knots the force runs straight, outside of them it stays as at the nearest one.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Literal

from pydantic import field_validator, model_validator

from config.effect_entry import JointEntry, quantity_by_place
from config.effects_joint import FORCE, LENGTH, VELOCITY
from config.section import quantity

LEAST_KNOTS, MOST_KNOTS = 2, 8
NEGLIGIBLE = 0.01  # share of a table's largest power: a fit's noise about 0
INPUTS = ("velocity", "position", "command", "pressure_difference")


class UnnamedRemainder(JointEntry):
    """A force (torque) on the joint that no effect accounts for, over exactly one of velocity, position, command and pressure
    difference; or friction over position. `longreach gap find --keep-remainder` writes it."""

    effect: Literal["unnamed_remainder"]
    velocity: tuple[float, ...] = quantity_by_place(VELOCITY, "knots: velocity of the joint, increasing", ())
    position: tuple[float, ...] = quantity_by_place(LENGTH, "knots: position of the joint, increasing", ())
    command_V: tuple[float, ...] = quantity("V", "knots: command as it reaches the valve or drive, increasing", ())
    pressure_difference_Pa: tuple[float, ...] = quantity("Pa", "knots: pressure in chamber A minus B, increasing", ())
    force: tuple[float, ...] = quantity_by_place(FORCE, "force on the joint at each knot, in its positive direction; 2 to 8 of them", ())
    friction: tuple[float, ...] = quantity_by_place(
        FORCE, "instead of force, over position only: sliding friction beyond that of the other effects, never less than none in all", ()
    )

    @field_validator("velocity", "position", "command_V", "pressure_difference_Pa")
    @classmethod
    def _increasing(cls, knots: tuple[float, ...]) -> tuple[float, ...]:
        for number, (low, high) in enumerate(pairwise(knots), 1):
            if not low < high:
                raise ValueError(f"knot {number} is {high:.6g} after {low:.6g}; knots must increase: sort them, each with its force")
        return knots

    @model_validator(mode="after")
    def _is_table(self) -> UnnamedRemainder:
        given = self._given()
        if len(given) != 1:
            found = ", ".join(given) or "none of them"
            raise ValueError(f"the force stands over exactly one of {', '.join(INPUTS)}; there is {found}: keep one list of knots")
        if not LEAST_KNOTS <= len(self.knots) <= MOST_KNOTS:
            raise ValueError(f"{given[0]} has {len(self.knots)} entries; a table has {LEAST_KNOTS} to {MOST_KNOTS} knots")
        if bool(self.force) == bool(self.friction):
            raise ValueError(f"{'both' if self.force else 'neither'} of force and friction: a table needs one of them")
        if len(self.values) != len(self.knots):
            word = "force" if self.force else "friction"
            raise ValueError(f"{given[0]} has {len(self.knots)} knots and {word} {len(self.values)} values: give one {word} a knot")
        if self.friction and not self.position:
            raise ValueError(f"friction stands over position, not over {given[0]}: give it as a force, or give the positions")
        return self

    @property
    def variable(self) -> str:
        """The word of the variable the force stands over: "velocity", "position", "command" or "pressure_difference"."""
        return self._given()[0]

    @property
    def knots(self) -> tuple[float, ...]:
        """Where the force is given, in SI."""
        return self.velocity or self.position or self.command_V or self.pressure_difference_Pa

    @property
    def values(self) -> tuple[float, ...]:
        """Force or friction at each knot."""
        return self.force or self.friction

    @property
    def drives(self) -> bool:
        """Whether a force over velocity pushes along with the motion at some speed, by more than a hundredth of the table's largest
        power: then it gives energy instead of taking it."""
        powers = [at * force for at, force in zip(self.velocity, self.force, strict=False)]
        return max(powers, default=0.0) > NEGLIGIBLE * max(map(abs, powers), default=0.0)

    def _given(self) -> list[str]:
        lists = (self.velocity, self.position, self.command_V, self.pressure_difference_Pa)
        return [word for word, knots in zip(INPUTS, lists, strict=True) if knots]
