"""How long a whole search takes: two 60 s logs of the simulated testbed at 1 kHz, an effect deleted from the rig file, all candidates.

Run: python -m benchmarks.gap [EFFECT@PLACE]. Not part of `make bench`: it takes about two minutes with the recording of the logs.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from config.load import LoadedRig, load_rig, rig_from_text
from daemon.cli.gap_demo import without
from daemon.lockstep import run_lockstep
from gap.find import find
from gap.search.settings import Settings

WANTED_S, WANTED_GIB = 60.0, 2.0
MOVES = (
    {"joint": "rotary", "by": "2 deg", "hold": "2 s", "speed": "20 deg/s", "acceleration": "200 deg/s^2"},
    {"joint": "rotary", "to": "0 deg", "hold": "2 s", "speed": "20 deg/s", "acceleration": "200 deg/s^2"},
    {"joint": "prismatic", "by": "1 in", "hold": "2 s", "speed": "6 in/s", "acceleration": "60 in/s^2"},
    {"joint": "prismatic", "to": "36 in", "hold": "2 s", "speed": "6 in/s", "acceleration": "60 in/s^2"},
)
STEPS = [dict(move) for _ in range(5) for move in MOVES]
LOGS = {
    "fit": {"maneuver": {"name": "multisine"}, "parameters": {"periods": 5}},
    "holdout": {"maneuver": {"name": "joint_steps"}, "parameters": {"steps": STEPS}},
}


def main() -> None:
    """Print seconds, processor seconds and peak memory; the first search of a process also loads the compiled kernel."""
    effect, _, where = (sys.argv[1] if len(sys.argv) > 1 else "coulomb_friction@rotary").partition("@")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        rig = load_rig("ornl_testbed")
        logs = [_log(rig, request, out / name, seed) for seed, (name, request) in enumerate(LOGS.items())]
        model = out / "model.yaml"
        model.write_text(without(rig.text, effect, where))
        started, processor = time.perf_counter(), time.process_time()
        found = find(model, logs[:1], logs[1:], out / "found", print, Settings(propose=False))
        seconds, spent = time.perf_counter() - started, time.process_time() - processor
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        names = ", ".join(f"{item['effect']} at {item['where']}" for item in found.content["findings"])
        print(f"{found.verdict.word}: {names or 'nothing'}")
        print(f"search                          {seconds:8.1f} s   (wanted: {WANTED_S:g})")
        print(f"processor time                  {spent:8.1f} s")
        print(f"peak memory                     {peak:8.2f} GiB (wanted: {WANTED_GIB:g})")


def _log(rig: LoadedRig, request: Mapping[str, Any], folder: Path, seed: int) -> Path:
    fresh = LoadedRig(rig_from_text(rig.text), rig.text, rig.path)
    return run_lockstep(fresh, [{**request, "approach": True}], folder, seed=seed)[0]


if __name__ == "__main__":
    main()
