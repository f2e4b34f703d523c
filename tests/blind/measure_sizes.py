"""Writes smallest_visible.json: what the finder itself says it could just have seen, on effect-free logs of development seeds.

One multiple in a study is one such size. An effect that the rig file has is taken out of file and hidden machine alike.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from blind.cases import FIT, HOLDOUT, PLACES, RIG, SIZES, UNSIZED, Case
from blind.one_case import finder_digest, rig_text
from blind.truth.effects import EFFECTS
from blind.truth.friction import BRISTLE
from blind.truth.session import Hidden, Setting, record
from config.load import load_rig, rig_from_text
from gap.candidates import candidates
from gap.executor import each, executor
from gap.find import find
from gap.settings import Settings

DEVELOPMENT_SEED = 900_100
Place = tuple[str, str]


def groups() -> list[list[Place]]:
    """Places looked at together: all that the rig file does not have, and each that it has alone."""
    plant = load_rig(RIG).rig.plant
    assert plant is not None
    present = {(entry.effect, entry.where) for entry in plant.effects}
    wanted = [place for place in PLACES if place[0] not in (*UNSIZED, "link_flexibility")]
    return [[p for p in wanted if p not in present], *[[p] for p in wanted if p in present]]


def measured(task: tuple[int, list[Place]]) -> list[dict[str, Any]]:
    """Sizes of one group of places."""
    number, places = task
    rig = load_rig(RIG).rig
    plant = rig.plant
    assert plant is not None
    present = {(entry.effect, entry.where) for entry in plant.effects}
    removed = tuple(p for p in places if p in present)
    hidden = tuple(Hidden(e, w, stiff_or_absent(e)) for e, w in removed)
    setting = Setting(DEVELOPMENT_SEED + number, hidden, False, BRISTLE)
    case = Case("", "development", setting, removed, 0.0, FIT, HOLDOUT)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "rig.yaml").write_text(rig_text(case))
        for take, (kinds, duration_s) in enumerate((FIT, HOLDOUT)):
            record(rig, setting, kinds, duration_s, take, folder / f"{take}.csv")
        logs = [folder / "0.csv"], [folder / "1.csv"]
        content = find(folder / "rig.yaml", *logs, folder / "out", lambda line: None, Settings(propose=False)).content
    return [_row(item, rig_text(case)) for item in content["not_seen"] if (item["effect"], item["where"]) in places]


def stiff_or_absent(effect: str) -> float:
    """Value with which an effect of the rig file is as good as absent in the hidden machine."""
    return 1e5 if effect == "link_flexibility" else 0.0


def _row(item: dict[str, Any], text: str) -> dict[str, Any]:
    rig = rig_from_text(text)
    assert rig.plant is not None
    found = next(c for c in candidates(rig, frozenset(rig.plant.sensors)) if (c.effect, c.where) == (item["effect"], item["where"]))
    free = found.free[0]
    first = next(iter(EFFECTS[item["effect"]]))
    side = -1.0 if found.starts[0][0] < free.start else 1.0
    limit = (free.start - free.low) if side < 0 else (free.high - free.start)
    visible = item["smallest_visible"]
    return {
        "effect": item["effect"], "where": item["where"], "parameter": first, "visible": side * visible if visible else None,
        "neutral": free.start, "limit": 0.9 * limit,
    }  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    rows: list[dict[str, Any]] = []
    tasks = list(enumerate(groups()))
    with executor(arguments.workers) as pool:
        for number, found in each(pool, measured, tasks):
            rows += found
            print(number, tasks[number][1], [r["visible"] for r in found], file=sys.stderr, flush=True)
    rows.sort(key=lambda r: (r["effect"], r["where"]))
    SIZES.write_text(json.dumps({"finder": finder_digest(), "seed": DEVELOPMENT_SEED, "sizes": rows}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
