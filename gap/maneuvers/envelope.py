"""Whether a simulated run stays inside the rig's safety envelope: what the daemon's interlocks would have stopped is not proposed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from config.errors import ManeuverError
from config.schema.rig import Rig
from gap.data.measured import Array

MARGIN = 0.9  # of a limit: the simulation that plans the run is known to be wrong
_Limit = tuple[str, float, float | None, float | None, str]  # signal, value, lowest, highest allowed, unit


def check_envelope(rig: Rig, signals: Mapping[str, Array], following_errors: Mapping[str, float], where: str) -> None:
    """`signals`: simulated readings by name; `following_errors`: the largest of every joint. ManeuverError for the first limit passed."""
    for name, value, low, high, unit in _limits(rig, signals, following_errors):
        if (high is not None and value > high) or (low is not None and value < low):
            limit = high if high is not None else low
            what = f"{name} would come too near its limit"
            raise ManeuverError(what, value=f"{value:.4g}", limit=f"{limit:.4g}", unit=unit, where=where, next_step="Make it smaller.")


def _limits(rig: Rig, signals: Mapping[str, Array], following_errors: Mapping[str, float]) -> Iterator[_Limit]:
    for joint, limits in rig.joints.items():
        unit = limits.position_unit
        yield f"following error of {joint}", following_errors[joint], None, MARGIN * limits.following_error_limit, unit
    bounds = rig.interlocks
    for name, values in signals.items():
        if name.endswith(".supply_pressure"):
            lowest = None if bounds.supply_pressure_min_Pa is None else bounds.supply_pressure_min_Pa / MARGIN
            yield name, float(np.min(values)), lowest, None, "Pa"
            yield name, float(np.max(values)), None, bounds.supply_pressure_max_Pa, "Pa"
        elif name.endswith(".return_pressure"):
            yield name, float(np.max(values)), None, bounds.return_pressure_max_Pa, "Pa"
        elif name == "tip.acceleration" and bounds.tip_acceleration_max_m_per_s2 is not None:
            yield name, float(np.max(np.abs(values))), None, MARGIN * bounds.tip_acceleration_max_m_per_s2, "m/s^2"
