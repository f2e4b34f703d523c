"""Which excited runs are realisations of one measurement: the same excitation but for its phases, under the same conditions."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from config.schema.rig import Rig
from tuning.experiments.excited_run import ExcitedRun, ResponseConditions
from tuning.responses.frequency_response import FrequencyResponse, sweep_response
from tuning.responses.multisine_response import multisine_response

# A response hardly changes within these. Distances, and no classes: a run on either side of a class's edge would stand alone.
SAME_M, SAME_SHARE, SAME_C, SAME_KG = 0.01, 0.01, 2.0, 0.001  # extension, share of a single axis's travel, oil, payload


def realisations(runs: Sequence[ExcitedRun], rig: Rig) -> list[list[FrequencyResponse]]:
    """The responses of the runs, those that may be averaged together in one list."""
    groups: list[tuple[object, list[FrequencyResponse]]] = []
    for run in runs:
        response = multisine_response(run) if run.maneuver["kind"] == "multisine" else sweep_response(run)
        at = response.conditions
        lines = (run.maneuver.get("period"), *response.frequencies_Hz.tolist())
        excitation = (response.source, at.joint, at.on, run.maneuver["amplitude"], lines)
        same = [group for other, group in groups if other == excitation and _alike(group[0].conditions, at, rig)]
        if same:
            same[0].append(response)
        else:
            groups.append((excitation, [response]))
    return [group for _, group in groups]


def _alike(here: ResponseConditions, there: ResponseConditions, rig: Rig) -> bool:
    low, high = rig.joints[here.joint].travel
    return (
        _near(here.extension_m, there.extension_m, SAME_M)
        and _near(here.position, there.position, SAME_SHARE * (high - low))
        and _near(here.oil_C, there.oil_C, SAME_C)
        and _near(here.payload_kg, there.payload_kg, SAME_KG)
    )


def _near(here: float, there: float, distance: float) -> bool:
    """Also what was measured on neither (NaN)."""
    return abs(here - there) <= distance or (isnan(here) and isnan(there))
