"""A plant without dry friction, whatever effects make it: bristles that are neither stiff nor damped carry no force.

To zero the friction itself would need the name of every effect that rubs, and one forgotten leaves the bristles' damping at work about
rest: drag that no joint has while it slides.
"""

from __future__ import annotations

from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import J, Vector


def bristles(parameters: Parameters, joint: str) -> list[int]:
    """Where the stiffness and the damping of a joint's bristles stand in the parameter vector."""
    return [parameters.offset(J.BRISTLE_STIFFNESS, joint), parameters.offset(J.BRISTLE_DAMPING, joint)]


def take_out_dry_friction(parameters: Parameters, joint: str) -> Vector:
    """Take it out of the parameters; returns the stiffness (N/m or N*m/rad) and the damping of the bristles that were there."""
    where = bristles(parameters, joint)
    were = parameters.values[where]
    parameters.values[where] = 0.0
    return were
