"""The search by evidence of an axis as it is before it looks for anything: the constants alone, fitted to one log."""

from __future__ import annotations

from pathlib import Path

from config.loading.load import LoadedRig, rig_from_text
from gap.data.experiments import experiments_of
from gap.data.measured import load
from gap.evidence.opening import opening
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import refitted
from gap.fitting.nuisance import nuisances
from gap.settings import Settings
from tests.support.gap import axis_logs


def constants_fitted(folder: Path, text: str, true: str, seed: int = 31) -> EvidenceSearch:
    """`text`: the rig file; `true`: that of the machine which wrote the log."""
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = [load(axis_logs.write(folder / f"{k}.csv", axis_logs.simulated(rig_from_text(true), seed + k, 6.0)), loaded.rig) for k in (0, 1)]
    names, few, _ = experiments_of(loaded, logs[:1], logs[1:], Settings())
    return refitted(opening(loaded.rig, nuisances(loaded, frozenset(names)), few, names), lambda line: None)
