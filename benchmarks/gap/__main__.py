"""How long a whole search takes: logs of the simulated testbed at 1 kHz, an effect deleted from the rig file, all candidates.

    python -m benchmarks.gap [EFFECT@PLACE] [--periods 5] [--workers 2]

For each length of the fit log (12 s a period of the multisine) and each number of threads: seconds, processor seconds, and what was
simulated for the verdict. Not part of `make bench`: a search takes about a minute on an idle machine, the recording of the logs another.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import patch

from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.cli.gap.gap_demo import without
from daemon.lockstep import run_lockstep
from gap.find import find
from gap.fitting import initial_states, simulate
from gap.search.settings import PROCESSORS, Settings
from recording.files.reader import read_log
from sim_backend.kernel.batch import WindowPlan

WANTED_S, WANTED_GIB = 60.0, 2.0
MOVES = (
    {"joint": "rotary", "by": "2 deg", "hold": "2 s", "speed": "20 deg/s", "acceleration": "200 deg/s^2"},
    {"joint": "rotary", "to": "0 deg", "hold": "2 s", "speed": "20 deg/s", "acceleration": "200 deg/s^2"},
    {"joint": "prismatic", "by": "1 in", "hold": "2 s", "speed": "6 in/s", "acceleration": "60 in/s^2"},
    {"joint": "prismatic", "to": "36 in", "hold": "2 s", "speed": "6 in/s", "acceleration": "60 in/s^2"},
)
STEPS = [dict(move) for _ in range(5) for move in MOVES]
CARRIED, RESTARTED = (simulate, "carry"), (initial_states, "restart")


class Counted:
    """A function of the kernel's batches, and what it has simulated: calls, and windows in all of them."""

    def __init__(self, place: ModuleType, name: str) -> None:
        self._function = getattr(place, name)
        self._lock = threading.Lock()
        self.calls = self.windows = 0

    def __call__(self, state: Any, p: Any, plan: WindowPlan, *rest: Any, **named: Any) -> Any:
        with self._lock:
            self.calls += 1
            self.windows += len(plan.starts)
        return self._function(state, p, plan, *rest, **named)


@contextmanager
def counted() -> Iterator[list[Counted]]:
    """All simulations of the searches within."""
    counts = [Counted(*place) for place in (CARRIED, RESTARTED)]
    with patch.object(*CARRIED, counts[0]), patch.object(*RESTARTED, counts[1]):
        yield counts


def main() -> None:
    """A line a search; the first of a process also loads the compiled kernel."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("effect", nargs="?", default="coulomb_friction@rotary", help="what is deleted, and where (default %(default)s)")
    parser.add_argument("--periods", type=int, nargs="+", default=[5], metavar="N", help="of the fit log's multisine (default 5: 60 s)")
    parser.add_argument("--workers", type=int, nargs="+", default=[PROCESSORS], metavar="N", help="threads (default %(default)s)")
    arguments = parser.parse_args()
    effect, _, where = arguments.effect.partition("@")
    with tempfile.TemporaryDirectory() as folder:
        out, rig = Path(folder), load_rig("ornl_testbed")
        model = out / "model.yaml"
        model.write_text(without(rig.text, effect, where))
        held = _log(rig, {"maneuver": {"name": "joint_steps"}, "parameters": {"steps": STEPS}}, out / "holdout", 1)
        for periods in arguments.periods:
            fitted = _log(rig, {"maneuver": {"name": "multisine"}, "parameters": {"periods": periods}}, out / f"fit{periods}", 0)
            for workers in arguments.workers:
                _search(model, fitted, held, out / f"found{periods}-{workers}", workers)
    print(
        f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB (wanted: {WANTED_GIB:g}); wanted: {WANTED_S:g} s"
    )


def _search(model: Path, fitted: Path, held: Path, out: Path, workers: int) -> None:
    said: list[str] = []
    with counted() as (carried, restarted):
        began, processor = time.perf_counter(), time.process_time()
        found = find(model, [fitted], [held], out, said.append, Settings(propose=False, workers=workers))
        seconds, spent = time.perf_counter() - began, time.process_time() - processor
    screened = next((line for line in said if line.startswith("screening")), "no candidate")
    names = ", ".join(f"{item['effect']} at {item['where']}" for item in found.content["findings"]) or "nothing"
    print(f"{read_log(fitted).columns['t_s'][-1]:.0f} s of fit log, {workers} threads, {screened}: {found.verdict.word}, {names}")
    print(f"  {seconds:.1f} s, {spent:.1f} processor seconds; {carried.calls} simulations of {carried.windows} windows, "
          f"{restarted.calls} restarts of {restarted.windows}", flush=True)  # fmt: skip


def _log(rig: LoadedRig, request: Mapping[str, Any], folder: Path, seed: int) -> Path:
    fresh = LoadedRig(rig_from_text(rig.text), rig.text, rig.path)
    return run_lockstep(fresh, [{**request, "approach": True}], folder, seed=seed)[0]


if __name__ == "__main__":
    main()
