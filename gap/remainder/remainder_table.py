"""The curve of an imbalance as a table that a rig file can hold: which variable, which knots, and the force at each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from config.schema.effect import Sizes
from config.schema.rig import Rig
from config.schema.section import yaml_key
from gap.balance.discrepancy import RUBBING
from gap.data.measured import Array
from gap.fitting.model import Free
from gap.outcome.model_file import written
from gap.suspects.sizes import sizes_of
from sim_backend.effects.unnamed_remainder import MOST_KNOTS, UnnamedRemainder

BALANCE = "force balance of "  # how an equation begins whose imbalance a table can hold
CLOSEST = 0.02  # of the curve's range between two knots
UNITS = {
    "linear": {"velocity": "m/s", "position": "m", "command": "V", "pressure_difference": "Pa", "force": "N"},
    "rotary": {"velocity": "rad/s", "position": "rad", "command": "V", "pressure_difference": "Pa", "force": "N*m"},
}


@dataclass(frozen=True, slots=True)
class RemainderTable:
    """Forces (N or N m, in the joint's positive direction) at increasing values of one variable (SI)."""

    joint: str
    motion: str  # "linear" or "rotary"
    variable: str  # a key of UNITS
    knots: Array
    force: Array
    acts: str = "force"  # or "friction": then it is against the motion

    def entry(self, force: Array) -> UnnamedRemainder:
        """As an entry of plant.effects."""
        place = {"effect": "unnamed_remainder", "where": self.joint, "quantity_kind": self.motion}
        return UnnamedRemainder.model_validate(place | {self.variable: list(self.knots), self.acts: list(force)})

    def free(self, rig: Rig) -> tuple[Free, ...]:
        """The forces as free numbers. What the balance says of them is their prior, as sure as they are large: it holds a knot that the
        fitted windows hardly reach."""
        sd, unit = max(float(np.max(np.abs(self.force))), 1e-9), UNITS[self.motion]["force"]
        most = max(_sizes(rig, self.joint).force, sd)
        return tuple(Free((self.acts, k), f"{self.acts}[{k}]", unit, float(f), sd, -most, most, True) for k, f in enumerate(self.force))

    def line(self, force: Array, remark: str) -> str:
        """The entry as a line of a rig file."""
        units = UNITS[self.motion]
        knots = ", ".join(f"{written(at)} {units[self.variable]}" for at in self.knots)
        forces = ", ".join(f"{written(value)} {units['force']}" for value in force)
        inside = f"effect: unnamed_remainder, where: {self.joint}, {self.variable}: [{knots}], {self.acts}: [{forces}]"
        return f"- {{{inside}}}  # [gap] {remark}"

    @property
    def seen_over(self) -> str:
        """`axis.position 0.01 to 0.2 m`."""
        return f"{self.joint}.{self.variable} {self.knots[0]:.4g} to {self.knots[-1]:.4g} {UNITS[self.motion][self.variable]}"


def tables(found: Mapping[str, Any], rig: Rig) -> list[RemainderTable]:
    """One table for every input of the joint's own that carries its imbalance (`gap.balance.discrepancy`), strongest first."""
    joint = str(found["equation"]).removeprefix(BALANCE)
    return [table for curve in found["carried_by"] for table in _tables(joint, curve, rig)]


def _tables(joint: str, curve: Mapping[str, Any], rig: Rig) -> Iterator[RemainderTable]:
    """The force that was missing is the imbalance with the other sign: it stood on the drive's side."""
    motion, name = rig.joints[joint].motion, str(curve["input"])
    force = -np.array(curve["value"])
    if name == f"{RUBBING}{joint}.position":
        yield from _over(joint, motion, "position", curve, -force, "friction")
        return
    if name == f"sign of {joint}.velocity":
        yield _jump(joint, motion, force, rig)
        return
    inputs = {f"{joint}.velocity", f"{joint}.command_V", f"{joint}.position", f"pressure difference at {joint}"}
    if name in inputs:
        word = "pressure_difference" if name.startswith("pressure") else yaml_key(name.removeprefix(f"{joint}."))
        yield from _over(joint, motion, word, curve, force, "force")


def _over(joint: str, motion: str, word: str, curve: Mapping[str, Any], values: Array, acts: str) -> Iterator[RemainderTable]:
    """As many knots of the curve as a table may have; none of a curve that is a point."""
    at = np.array(curve["at"])
    knots = _apart(np.interp(np.linspace(0, len(at) - 1, min(len(at), MOST_KNOTS)), np.arange(len(at)), at))
    if len(knots) > 1:
        yield RemainderTable(joint, motion, word, knots, np.interp(knots, at, values), acts)


def _apart(at: Array) -> Array:
    """The knots without those that lie as good as on the one before."""
    kept = [float(at[0])]
    for value in at[1:]:
        if value - kept[-1] > CLOSEST * (at[-1] - at[0]):
            kept.append(float(value))
    return np.array(kept)


def _jump(joint: str, motion: str, force: Array, rig: Rig) -> RemainderTable:
    """A force that changes with the direction, over as little velocity as friction's bristles take to fade, and no steeper than the
    integration bears."""
    sizes = _sizes(rig, joint)
    assert rig.plant is not None
    half = max(sizes.slow, 0.5 * abs(float(force[-1] - force[0])) * rig.plant.step_s / sizes.mass)
    return RemainderTable(joint, motion, "velocity", np.array([-half, half]), np.array([force[0], force[-1]]))


def _sizes(rig: Rig, joint: str) -> Sizes:
    assert rig.plant is not None
    return sizes_of(rig, rig.plant, joint)
