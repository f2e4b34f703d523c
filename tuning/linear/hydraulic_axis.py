"""Whether a rig is one hydraulic axis: asked also by what must not wait for python-control to load."""

from __future__ import annotations

from config.schema.rig import Rig


def is_hydraulic_axis(rig: Rig) -> bool:
    """A single axis with a valve in its plant."""
    if rig.arm.kind != "single_axis" or rig.plant is None:
        return False
    return all(getattr(joint, "valve", None) is not None for joint in rig.plant.joints.values())
