"""How long a whole search takes: logs of the simulated testbed at 1 kHz, an effect deleted from the rig file, all candidates.

    python -m benchmarks.gap [EFFECT@PLACE] [--lengths 20 60] [--workers 2] [--one-in 1 2 4] [--dask 1 2 --verdicts 4]

For each length of the two logs (a multisine to fit, steps of both joints to decide), each number of threads and each share of the
candidates (one in so many of all other effects): seconds, processor seconds, and what was simulated for the verdict. With `--dask` then the
same for several verdicts beside each other on so many workers of a Dask cluster. Not part of `make bench`: a search takes about a minute on
an idle machine, the recording of the logs another.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.gap.measured_search import Search, measured, measured_on_dask
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.cli.gap.gap_demo import without
from daemon.lockstep import run_lockstep
from gap.settings import PROCESSORS
from recording.files.reader import read_log

WANTED_S, WANTED_GIB = 60.0, 2.0
MOVES = (
    {"joint": "rotary", "by": "2 deg", "hold": "2 s", "speed": "20 deg/s", "acceleration": "200 deg/s^2"},
    {"joint": "rotary", "to": "0 deg", "hold": "2 s", "speed": "20 deg/s", "acceleration": "200 deg/s^2"},
    {"joint": "prismatic", "by": "1 in", "hold": "2 s", "speed": "6 in/s", "acceleration": "60 in/s^2"},
    {"joint": "prismatic", "to": "36 in", "hold": "2 s", "speed": "6 in/s", "acceleration": "60 in/s^2"},
)
ROUND_S, PERIOD_S = 9.6, 10.0  # of these moves, and of the multisine


def main() -> None:
    """A line a search; the first of a process also loads the compiled kernel."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("effect", nargs="?", default="coulomb_friction@rotary", help="what is deleted, and where (default %(default)s)")
    parser.add_argument("--lengths", type=float, nargs="+", default=[20.0], metavar="S", help="of each log, s, about (default 20)")
    parser.add_argument("--workers", type=int, nargs="+", default=[PROCESSORS], metavar="N", help="threads (default %(default)s)")
    parser.add_argument("--one-in", type=int, nargs="+", default=[1], metavar="N", help="so many candidates is tried (default: all)")
    parser.add_argument("--dask", type=int, nargs="+", default=[], metavar="N", help="workers of a Dask cluster, one thread each")
    parser.add_argument("--verdicts", type=int, default=4, metavar="N", help="searches on each cluster (default %(default)s)")
    arguments = parser.parse_args()
    effect, _, where = arguments.effect.partition("@")
    with tempfile.TemporaryDirectory() as folder:
        out, rig = Path(folder), load_rig("ornl_testbed")
        model = out / "model.yaml"
        model.write_text(without(rig.text, effect, where))
        for length_s in arguments.lengths:
            fitted, held = _pair(rig, length_s, out / f"{length_s:g}")
            for workers, one_in in product(arguments.workers, arguments.one_in):
                _search(Search(model, fitted, held, out / f"found{length_s:g}-{workers}-{one_in}", workers, effect, one_in))
            for workers in arguments.dask:
                _verdicts(Search(model, fitted, held, out / f"dask{length_s:g}-{workers}", 1), workers, arguments.verdicts)
    print(
        f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB (wanted: {WANTED_GIB:g}); wanted: {WANTED_S:g} s"
    )


def _search(search: Search) -> None:
    took = measured(search)
    print(f"{_lengths(search)}, {search.threads} threads, {took.screened}: {took.found}\n  {took.line}", flush=True)


def _verdicts(search: Search, workers: int, verdicts: int) -> None:
    took = measured_on_dask(search, workers, verdicts)
    seconds = max(one.ended for one in took) - min(one.began for one in took)
    found = "; ".join(sorted({one.found for one in took}))
    print(f"{_lengths(search)}, {workers} Dask workers, {verdicts} verdicts: {found}")
    print(f"  {seconds / verdicts:.1f} s a verdict; each search:")
    print("\n".join(f"  {one.line}" for one in took), flush=True)


def _lengths(search: Search) -> str:
    fit_s, held_s = (float(read_log(path).columns["t_s"][-1]) for path in (search.fitted, search.held))
    return f"{fit_s:.0f} s to fit, {held_s:.0f} s to decide"


def _pair(rig: LoadedRig, length_s: float, folder: Path) -> tuple[Path, Path]:
    """A log to fit and one to decide of about the same length."""
    periods = max(round(length_s / PERIOD_S), 1)
    steps = [dict(move) for _ in range(max(round(length_s / ROUND_S), 1)) for move in MOVES]
    fitted = _log(rig, {"maneuver": {"name": "multisine"}, "parameters": {"periods": periods}}, folder / "fit", 0)
    return fitted, _log(rig, {"maneuver": {"name": "joint_steps"}, "parameters": {"steps": steps}}, folder / "holdout", 1)


def _log(rig: LoadedRig, request: Mapping[str, Any], folder: Path, seed: int) -> Path:
    fresh = LoadedRig(rig_from_text(rig.text), rig.text, rig.path)
    return run_lockstep(fresh, [{**request, "approach": True}], folder, seed=seed)[0]


if __name__ == "__main__":
    main()
