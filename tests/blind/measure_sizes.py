"""Writes smallest_visible.json for a new study: what counts as one size of each effect.

Where the rig file lacks the effect: what the search says it could just have named on an effect-free log of a development seed (LuGre
friction, exact constants). Where the rig file has it: a tenth of its own value, so that ten sizes are the file without its entry.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from blind.cases import BY_HAND, FIT, HOLDOUT, PLACES, RIG, SIZES
from blind.one_case import finder_digest
from blind.truth.effects import EFFECTS
from blind.truth.friction import BRISTLE
from blind.truth.session import Setting, record
from config.load import load_rig
from gap.candidates import candidates
from gap.find import find
from gap.settings import Settings

DEVELOPMENT_SEED = 900_100
AT_MOST = {"payload_error": 2.0, "inertia_error": 4.0}  # kg, kg m²; ten times that is as much as the arm carries
Place = tuple[str, str]


def wanted() -> tuple[list[Place], list[Place]]:
    """Places of effects that the rig file does not have, and of those it has."""
    plant = load_rig(RIG).rig.plant
    assert plant is not None
    present = {(entry.effect, entry.where) for entry in plant.effects}
    sized = [place for place in PLACES if place[0] not in BY_HAND]
    return [p for p in sized if p not in present], [p for p in sized if p in present]


def claimed(places: Sequence[Place]) -> list[dict[str, Any]]:
    """What the search says it could just have seen on an effect-free log."""
    rig = load_rig(RIG).rig
    setting = Setting(DEVELOPMENT_SEED, (), False, BRISTLE)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for take, (kinds, duration_s) in enumerate((FIT, HOLDOUT)):
            record(rig, setting, kinds, duration_s, take, folder / f"{take}.csv")
        logs = [folder / "0.csv"], [folder / "1.csv"]
        content = find(RIG, *logs, folder / "out", lambda line: None, Settings(propose=False)).content
    visible = {(item["effect"], item["where"]): item["smallest_visible"] or np.inf for item in content["not_seen"]}
    return [from_claim(place, visible[place]) for place in places]


def from_claim(place: Place, visible: float) -> dict[str, Any]:
    """One multiple: the claim, at most a tenth of the plausible range."""
    rig = load_rig(RIG).rig
    assert rig.plant is not None
    found = next(c for c in candidates(rig, frozenset(rig.plant.sensors)) if (c.effect, c.where) == place)
    free = found.free[0]
    side = -1.0 if found.starts[0][0] < free.start else 1.0
    limit = 0.9 * ((free.start - free.low) if side < 0 else (free.high - free.start))
    one = side * min(abs(visible), 0.1 * limit, AT_MOST.get(place[0], np.inf))
    return _size(place, one, free.start, limit) | {"claimed": visible if np.isfinite(visible) else None}


def own(place: Place) -> dict[str, Any]:
    """One multiple: a tenth of the rig file's own value."""
    plant = load_rig(RIG).rig.plant
    assert plant is not None
    entry = next(e for e in plant.effects if (e.effect, e.where) == place)
    value = float(entry.model_dump()[next(iter(EFFECTS[place[0]]))])
    return _size(place, 0.1 * value, 0.0, value)


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
    missing, present = wanted()
    rows = [*claimed(missing), *(own(place) for place in present)]
    rows.sort(key=lambda r: (r["effect"], r["where"]))
    SIZES.write_text(json.dumps({"finder": finder_digest(), "seed": DEVELOPMENT_SEED, "sizes": rows}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
