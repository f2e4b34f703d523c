"""Two explanations on one maneuver, which is run on the rig of the first."""

from __future__ import annotations

from typing import Any

from config.loading.load import LoadedRig
from gap.maneuvers.closed_loop import measured_on
from gap.maneuvers.separation import Comparison, Rival, observed


def compare(loaded: LoadedRig, truth: Rival, rival: Rival, maneuver: dict[str, Any]) -> Comparison:
    """ManeuverError when that run would not be safe."""
    return observed(loaded, truth, measured_on(truth.model.fitted_rig(), maneuver)).beside(rival)
