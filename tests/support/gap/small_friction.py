"""Searches before their first effect on the single axis: the rig file lacks the Coulomb friction of the truth, which is so small that it
takes many windows to see it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import Measured, load
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.search.opening import experiments_of, started
from gap.search.search_state import GateSearch
from gap.search.settings import Settings
from tests.support.gap import axis_logs

OWN_N = 20.39  # the shipped axis's friction
NOISE_UM = 2.0  # of the encoder, as the rig file has it
MODEL = axis_logs.axis_text("coulomb_friction", noise_um=NOISE_UM)


@dataclass(frozen=True, slots=True)
class Log:
    """A log of an axis with so much Coulomb friction. With more noise than the rig file's it leaves a rest that nothing explains."""

    friction_N: float
    seed: int
    duration_s: float = 12.0
    noise_um: float = NOISE_UM

    def written(self, path: Path) -> Path:
        text = axis_logs.axis_text(noise_um=self.noise_um).replace(f"friction: {OWN_N}", f"friction: {self.friction_N}")
        return axis_logs.write(path, axis_logs.simulated(rig_from_text(text), self.seed, self.duration_s))


def opened(folder: Path, fit: Log, *holdouts: Log, text: str = MODEL) -> GateSearch:
    """The constants of the rig file `text` refitted to `fit`."""
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs: Sequence[Measured] = [load(log.written(folder / f"{k}.csv"), loaded.rig) for k, log in enumerate((fit, *holdouts))]
    names, few, held = experiments_of(loaded, logs[:1], logs[1:], Settings(propose=False))
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    return started(model, few, held, frozenset(names), lambda line: None)[0]
