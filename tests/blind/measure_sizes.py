"""Writes smallest_visible.json for a new study: what counts as one size of each effect, for each form of friction, with and without
chamber pressures.

What the search says it could just have named on an effect-free log of a development seed, constants jittered. Of effects that the rig file
has, what it says of the same signature without the entry.
"""

from __future__ import annotations

import json
import sys
import tempfile
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from config.loading.load import load_rig
from gap.data.measured import load
from gap.executor import each, executor
from gap.find import search_gap
from gap.search.hold_out_sizes import Judge
from gap.search.search_state import GateSearch
from gap.search.select import least_t
from gap.search.settings import Settings
from gap.signatures.candidates import candidates
from gap.signatures.projection import ConstantsProjection, Probe
from tests.blind.cases import BY_HAND, FIT, HOLDOUT, PLACES, RIG, SIZES, Case
from tests.blind.one_case import commit, finder_digest, rig_text
from tests.blind.truth.effects import EFFECTS
from tests.blind.truth.friction import BRISTLE, RIGID, SLIP
from tests.blind.truth.session import Setting, record

DEVELOPMENT_SEED = 900_100
OF_OWN = 1.0  # ten times that is ten times as much as the rig has
LINEAR = {"cross_leakage": 0.3, "external_leakage": 0.3, "viscous_friction": 0.3}  # claims, as straight lines, known to be too large
Place = tuple[str, str]


def measured(form: float, chambers: bool, seed: int) -> list[dict[str, Any]]:
    """One size of every effect that is scaled, on one pair of effect-free logs."""
    setting = Setting(seed, (), True, form, chambers)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        case = Case("development", "null", setting, (), 0.0, FIT, HOLDOUT)
        for take, (kinds, duration_s) in enumerate((FIT, HOLDOUT)):
            record(load_rig(RIG).rig, setting, kinds, duration_s, take, folder / f"{take}.csv")
        (folder / "rig.yaml").write_text(rig_text(case))
        loaded = load_rig(folder / "rig.yaml")
        fit, holdout = ([load(folder / f"{take}.csv", loaded.rig)] for take in range(2))
        found = search_gap(loaded, fit, holdout, lambda line: None, Settings(workers=1, propose=False))
    claims = {(item["effect"], item["where"]): item["smallest_visible"] or np.inf for item in found.content["not_seen"]}
    present = claims_of_present(found.state)
    rows = [
        from_claim(place, present.get(place, claims.get(place, np.inf)), place in present) for place in PLACES if place[0] not in BY_HAND
    ]
    return [row | {"form": form, "chambers": chambers} for row in rows]


def claims_of_present(state: GateSearch) -> dict[Place, float]:
    """The size at which each effect of the rig file would have been named, had it been missing: from the signature of its first number,
    all others projected out, on the fit logs and on the hold-out."""
    model, found = state.current.model, dict[Place, float]()
    assert model.rig.plant is not None
    tried = len(candidates(model.rig, state.channels))
    for number, entry in enumerate(model.rig.plant.effects):
        first = next(iter(EFFECTS.get(entry.effect, {"": ""})))
        mine = [k for k, free in enumerate(model.free) if free.path == ("effects", number, first)]
        if mine:
            found[(entry.effect, entry.where)] = _claim_of(state, mine[0], least_t(tried))
    return found


def _claim_of(state: GateSearch, mine: int, least: float) -> float:
    """Of one number of the rig file, all others free."""
    current, scale = state.current, state.current.model.free[mine].scale
    others = [k for k in range(len(current.model.free)) if k != mine]
    less = replace(
        current,
        model=current.model.restricted(others),
        jacobian=tuple(j[others] for j in current.jacobian),
        columns=tuple(c[others] for c in current.columns),
    )
    projection = ConstantsProjection(less, state.costs)
    row = projection.flat([c[mine] for c in current.columns])[None, :]
    energy = max(float(np.sum(projection.project_out(row) ** 2)), 1e-30)
    theta = current.model.theta.copy()
    theta[mine] += scale
    probe = Probe(current.model.with_theta(theta), scale, energy, projection.answers(row)[0])
    on_fit_logs = scale * float(np.sqrt(state.seen_at / energy))
    return Judge(less, state.seen, state.costs, least).least_sizes({0: probe}, {0: on_fit_logs})[0]


def from_claim(place: Place, visible: float, present: bool) -> dict[str, Any]:
    """One multiple: the claim, at most the plausible range; of the rig file's effects at most their own value or 0.3 of it."""
    plant = load_rig(RIG).rig.plant
    assert plant is not None
    less = plant.model_copy(update={"effects": tuple(e for e in plant.effects if (e.effect, e.where) != place)})
    rig = load_rig(RIG).rig.model_copy(update={"plant": less})
    found = next(c for c in candidates(rig, frozenset(plant.sensors)) if (c.effect, c.where) == place)
    free = found.free[0]
    side = -1.0 if found.starts[0][0] < free.start and not present else 1.0
    limit = 0.9 * ((free.start - free.low) if side < 0 else (free.high - free.start))
    neutral = 0.0 if present else free.start
    one = side * min(abs(visible), limit, LINEAR.get(place[0], OF_OWN) * own(place))
    return _size(place, one, neutral, limit) | {"claimed": float(f"{visible:.4g}") if np.isfinite(visible) else None}


def own(place: Place) -> float:
    """The rig file's own value; infinite for effects it does not have."""
    plant = load_rig(RIG).rig.plant
    assert plant is not None
    values = [e.model_dump()[next(iter(EFFECTS[place[0]]))] for e in plant.effects if (e.effect, e.where) == place]
    return float(values[0]) if values else np.inf


def _size(place: Place, visible: float, neutral: float, limit: float) -> dict[str, Any]:
    parameter = next(iter(EFFECTS[place[0]]))
    return {
        "effect": place[0],
        "where": place[1],
        "parameter": parameter,
        "visible": float(f"{visible:.4g}"),
        "neutral": neutral,
        "limit": limit,
    }


def main() -> int:
    settings = [(form, chambers, DEVELOPMENT_SEED + k) for k, (form, chambers) in enumerate(product((SLIP, RIGID, BRISTLE), (False, True)))]
    with executor(None, None) as pool:
        parts = dict(each(pool, _measured, settings))
    rows = [row for part in parts.values() for row in part]
    rows.sort(key=lambda r: (r["effect"], r["where"], r["form"], r["chambers"]))
    lines = ",\n  ".join(json.dumps(row) for row in rows)
    head = json.dumps({"finder": finder_digest(), "commit": commit(), "seeds": [seed for _, _, seed in settings]})
    SIZES.write_text(f'{head[:-1]},\n "sizes": [\n  {lines}\n ]\n}}\n')
    return 0


def _measured(setting: tuple[float, bool, int]) -> list[dict[str, Any]]:
    return measured(*setting)


if __name__ == "__main__":
    sys.exit(main())
