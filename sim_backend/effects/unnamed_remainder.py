"""What nobody has a name for, as a table: F(v), F(x), F(u) or F(P_A − P_B), a force on the joint in its positive direction; or friction
over position, g(v) = F_c + table(x) + … ≥ 0. Between knots it runs straight, outside of them it stays as at the nearest one.

No physics: only what a balance of forces lacked over the range in which it was seen. The search never tries it, and never calls it found.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Literal

from pydantic import field_validator, model_validator

from config.schema.effect import Case, Effect, Write
from config.schema.effect_entry import FORCE, LENGTH, VELOCITY, JointEntry, quantity_by_place
from config.schema.plant_joint import PlantJoint
from config.schema.section import quantity
from sim_backend.memory.layout import J

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

    def obstacles(self, joint: PlantJoint) -> Iterator[str]:
        if joint.is_imposed:
            yield "moves nothing: the motion of this joint is imposed"
        if self.pressure_difference_Pa and not joint.is_hydraulic:
            yield "needs a hydraulic actuator there for a table over pressure_difference"

    def warnings(self) -> Iterator[str]:
        """A table of forces need not take energy, as friction does. It may only take back what friction in the file is too large by."""
        if self.drives:
            yield (
                f"unnamed_remainder at {self.where} pushes along with the motion at some velocity: beyond what friction takes there it "
                "gives energy, and a simulated joint may never rest"
            )

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


def _chosen(word: str, code: float) -> tuple[Write, Write]:
    """The knots over one variable, and which it is; an empty list writes nothing."""
    return Write(word, J.TABLE_AT_0, convert=tuple), Write(word, J.TABLE_INPUT, convert=lambda knots: (code,) if knots else ())


def _acting(word: str, rubs: float) -> tuple[Write, Write, Write]:
    """The values at the knots, and whether they are friction. A table of nothing but zeros is none."""
    return (
        Write(word, J.TABLE_FORCE_0, convert=tuple),
        Write(word, J.TABLE_KNOTS, convert=lambda values: (float(len(values)),) if any(values) else ()),
        Write(word, J.TABLE_RUBS, convert=lambda values: (rubs,) if values else ()),
    )


EFFECT = Effect(
    entry=UnnamedRemainder,
    order=320,
    writes=(
        *(write for code, word in enumerate(INPUTS, 1) for write in _chosen(word, float(code))),
        *_acting("force", 0.0),
        *_acting("friction", 1.0),
    ),
    neutral={"force": 0.0, "friction": 0.0},
    fingerprint="Whatever the model still lacks in the balance of forces, over the one variable that carries most of it.",
    look_alikes={},
    cases=(
        Case("rotary", {"velocity": [-0.2, 0.0, 0.2], "force": [40, 0, -40]}, "rotary.position"),
        Case("rotary", {"position": [-0.1, 0.1], "force": [30, -30]}, "rotary.position"),
        Case("prismatic", {"position": [0.9, 1.1], "friction": [0, 900]}, "prismatic.pressure_a"),
        Case("prismatic", {"command": ["-3 V", "3 V"], "force": [200, -200]}, "prismatic.pressure_a"),
        Case("prismatic", {"pressure_difference": ["-10 bar", "10 bar"], "force": [200, -200]}, "prismatic.pressure_a"),
    ),
)
