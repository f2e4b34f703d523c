"""Numbers that the rig file has and a fault changes: how far they may be from what is stated, in a study."""

from __future__ import annotations

import numpy as np

from config.schema.rig import Rig
from tests.blind.truth.effects import EFFECTS, RATED_FLOW

# Number and place; how many times as large and as small it may be. Less friction, leakage or hysteresis than half hardly shows, a valve
# of a third or three times the flow is the most that the servo holds; viscous friction of six times is the plausible range's end.
LARGEST = {
    ("coulomb_friction", "rotary"): (10.0, 10.0), ("coulomb_friction", "prismatic"): (10.0, 10.0),
    ("stiction", "prismatic"): (10.0, 1.0), ("viscous_friction", "rotary"): (5.5, 10.0), ("viscous_friction", "prismatic"): (10.0, 10.0),
    ("valve_lag", "rotary"): (10.0, 1.0), ("valve_hysteresis", "prismatic"): (10.0, 1.0), ("cross_leakage", "rotary"): (10.0, 1.0),
    ("hose_compliance", "prismatic"): (10.0, 1.0), (RATED_FLOW, "rotary"): (3.0, 3.0), (RATED_FLOW, "prismatic"): (3.0, 3.0),
}  # fmt: skip
CHANGEABLE = tuple(LARGEST)
LEAST = 2.0


def stated(rig: Rig, number: tuple[str, str]) -> float:
    """As the rig file has it, SI."""
    effect, where = number
    plant = rig.plant
    assert plant is not None
    if effect == RATED_FLOW:
        return float(plant.joints[where].valve.rated_flow_m3_per_s)  # type: ignore[union-attr]
    entry = next(e for e in plant.effects if (e.effect, e.where) == number)
    return float(entry.model_dump()[next(iter(EFFECTS[effect]))])


def draw_times(number: tuple[str, str], draw: np.random.Generator) -> float:
    """Twice or more as large, or half or less, as far as the number may go; evenly in the logarithm."""
    up, down = LARGEST[number]
    larger = down < LEAST or bool(draw.random() < 0.5)
    times = float(np.exp(draw.uniform(np.log(LEAST), np.log(up if larger else down))))
    return times if larger else 1.0 / times
