"""Along a valley that bends, a fit goes as far as the priors ask: of a mass and an inertia that is not modelled logs know the sum only."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from config.loading.load import rig_from_text
from gap.evidence.promises import widened
from gap.evidence.refinement import finished
from gap.evidence.score.prior import prior_of
from gap.evidence.set_fits import refined
from gap.evidence.stages import refitted
from gap.fitting.model import Model
from tests.gap.evidence.test_effect_free import opened, rig_file
from tests.support.gap import axis_logs

TRUE_KG = 102.24
SURE_KG = 0.2  # of the sum, by such a log


def number_of(model: Model, name: str) -> int:
    return next(k for k, f in enumerate(model.free) if f.key.split(".")[-1] == name)


def likeliest_extra_kg(model: Model) -> float:
    """Of all ways to divide the true mass, by the priors alone: ln-normal of the mass, half-normal of the extra."""
    weights, free = prior_of(model).precision, model.free
    mass, extra = number_of(model, "mass"), number_of(model, "extra")

    def cost(extra_kg: float) -> float:
        of_mass = np.log((TRUE_KG - extra_kg) / free[mass].start) / np.log1p(free[mass].scale / free[mass].start)
        return float(weights[mass] * of_mass**2 + weights[extra] * (extra_kg / free[extra].scale) ** 2)

    return float(minimize_scalar(cost, bounds=(0.0, 20.0), method="bounded").x)


def test_what_a_constant_pays_too_much_for_goes_to_the_effect_that_does_the_same(tmp_path: Path) -> None:
    loaded = rig_file()
    heavier = rig_from_text(axis_logs.axis_text().replace("mass: 95.1089 kg", f"mass: {TRUE_KG} kg"))
    search, _ = opened(tmp_path, loaded, [axis_logs.simulated(heavier, 31 + k, 6.0) for k in (0, 1)])
    search = refitted(search, lambda line: None)
    alone = search.null.model
    assert alone.theta[number_of(alone, "mass")] == pytest.approx(TRUE_KG, abs=SURE_KG)
    beside = widened(search, search.null)
    fit = refined(beside, next(w for w in beside.waiting if w.labels == {"inertia_error at axis"}))
    assert fit.log_z > search.null.log_z
    done = finished(search.seen, fit.suspects, fit.at)  # as the search takes every set that holds a share
    mass, extra = (float(done.model.theta[number_of(done.model, name)]) for name in ("mass", "extra"))
    assert mass + extra == pytest.approx(TRUE_KG, abs=SURE_KG)
    assert extra == pytest.approx(likeliest_extra_kg(done.model), abs=1.0)
