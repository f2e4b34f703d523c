"""Constants that no fit may move (tagged [fixed], or 0) and that the logs want elsewhere.

Beside the finished model each is left free by itself: where a Gauss-Newton step of it and all other numbers on the fit logs is clear (score
test; C. Rao, Math. Proc. Cambridge Phil. Soc. 44, 1948) it is fitted with them. It is said where the hold-out falls with
it by more than chance and friction of another form can feign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from config.loading.load import LoadedRig
from config.parsing.provenance import FIXED
from config.progress import Progress
from gap.fitting.evaluation import FLOOR, evaluate, mean_cost
from gap.fitting.fit import Fit, covariance, fit, full_step
from gap.fitting.model import Free, Model
from gap.fitting.nuisance import held
from gap.fitting.sensitivity import projected, sensitivities
from gap.outcome.search_state import SearchState
from gap.suspects.sizes import sizes_of

FINISHED = "the finished model"
MOST = 3  # constants that are fitted, those asked for most clearly
LEAST_T = 3.5
LEAST_DROP = 0.02  # noise floors …
LEAST_GAIN = 0.15  # … and of the excess over the floor


@dataclass(frozen=True, slots=True)
class HeldConstant:
    """One held constant (SI), where the logs want it, with 95 % half width, and the hold-out's cost before and after.

    `beside`: "the finished model", "constants alone", or the label of the name that stands for it. `line`: where the file states it.
    """

    free: Free
    value: float
    half_width: float
    before: float
    after: float
    beside: str = FINISHED
    line: int | None = None

    def as_dict(self) -> dict[str, Any]:
        low, high = (float(f"{self.value + side * self.half_width:.6g}") for side in (-1, 1))
        return {
            "constant": self.free.key,
            "held": self.free.start,
            "because": "fixed" if self.free.tag == FIXED else "0",
            "beside": self.beside,
            "line": self.line,
            "wanted": {"value": float(f"{self.value:.6g}"), "unit": self.free.unit, "ci95": [low, high]},
            "holdout_before": self.before,
            "holdout_after": self.after,
        }


def held_constants(loaded: LoadedRig, state: SearchState, progress: Progress) -> list[HeldConstant]:
    """Those that would take most from the hold-out first; none where nothing is held."""
    return wanted(held(loaded, state.channels), state, progress)


def wanted(constants: Sequence[Free], state: SearchState, progress: Progress) -> list[HeldConstant]:
    """Of these constants the ones that the logs want elsewhere, beside the present model of the search."""
    extra = [_scaled(free, state.current.model) for free in constants]
    if not extra:
        return []
    done = _with(state.current, extra)
    own = len(state.current.model.free)
    asked = [(number, _t(state, done, own, number)) for number in range(own, own + len(extra))]
    clear = sorted((item for item in asked if abs(item[1]) >= LEAST_T), key=lambda item: -abs(item[1]))[:MOST]
    if clear:
        progress(f"fitting with {', '.join(done.model.free[number].key for number, _ in clear)} free, one at a time")
    found = [_fitted(state, done.model.restricted([*range(own), number])) for number, _ in clear]
    return sorted((item for item in found if item.before - item.after >= _least(item.before)), key=lambda item: item.after)


def _least(cost: float) -> float:
    """What a constant must take from a cost, in noise floors, to be told."""
    return max(LEAST_DROP, LEAST_GAIN * (cost - FLOOR))


def _with(current: Fit, extra: list[Free]) -> Fit:
    """The fit with the held constants free beside the others; none has moved."""
    model = current.model
    theta = np.concatenate([model.theta, [free.start for free in extra]])
    model = replace(model, free=(*model.free, *extra), theta=theta)
    numbers = range(len(current.model.free), len(model.free))
    raw = sensitivities(model, [e.experiment for e in current.evaluations], numbers, [e.readings for e in current.evaluations])
    columns = [np.concatenate([old, projected(e, j)]) for e, old, j in zip(current.evaluations, current.columns, raw, strict=True)]
    return replace(current, model=model, columns=tuple(columns))


def _t(state: SearchState, done: Fit, own: int, number: int) -> float:
    """How clearly the fit logs want the number moved, all others free beside it; 0 where it could only go where its key may not."""
    keep = [*range(own), number]
    alone = replace(done, model=done.model.restricted(keep), columns=tuple(columns[keep] for columns in done.columns))
    free, (step, sd) = done.model.free[number], full_step(alone, state.costs)
    blocked = (step[-1] > 0.0 and free.start >= free.high) or (step[-1] < 0.0 and free.start <= free.low)
    return 0.0 if blocked or not sd[-1] > 0.0 else float(step[-1] / sd[-1])


def _fitted(state: SearchState, model: Model) -> HeldConstant:
    """The constant, last of the model's numbers, fitted with all others; from the rig file's own constants where that ends better."""
    fits = [fit(start, state.experiments, state.costs) for start in (model, model.with_own_constants())]
    done = min(fits, key=lambda one: one.cost)
    after = mean_cost([evaluate(experiment, done.model, state.costs) for experiment in state.holdouts])
    half_width = 1.96 * float(np.sqrt(max(covariance(done, state.costs)[-1, -1], 0.0)))
    return HeldConstant(model.free[-1], float(done.model.theta[-1]), half_width, state.cost, after)


def _scaled(free: Free, model: Model) -> Free:
    """A constant of 0 has no size of its own: a hundredth of what is large where it stands, or ten times its sensor's noise."""
    if free.scale > 0.0:
        return free
    plant = model.rig.plant
    assert plant is not None
    if free.path[0] == "sensors":
        return replace(free, scale=10.0 * sizes_of(model.rig, plant, f"sensor:{free.path[1]}").noise)
    if free.path[0] != "joints":
        sizes = sizes_of(model.rig, plant, "link")
        return replace(free, scale=0.01 * {"Pa": sizes.pressure, "kg": sizes.payload, "N*m^2": sizes.bending}.get(free.unit, 1.0))
    sizes = sizes_of(model.rig, plant, str(free.path[1]))
    large = {"Pa": sizes.pressure, "kg": sizes.mass, "kg*m^2": sizes.mass, "N": sizes.force, "N*m": sizes.force}
    return replace(free, scale=0.01 * large.get(free.unit, 1.0))
