"""One search, with what it takes: seconds, processor seconds, simulations. Here with threads, or several beside each other on Dask's
workers."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import patch
from zlib import crc32

from config.schema.rig import Rig
from gap.evidence import opening, search_state
from gap.executor import each, executor
from gap.find import find
from gap.fitting import initial_states, simulate
from gap.settings import Settings
from gap.suspects.candidates import Candidate, candidates
from sim_backend.kernel.batch import WindowPlan

CARRIED, RESTARTED = (simulate, "carry"), (initial_states, "restart")
ASKING = (opening, search_state)  # for the candidates


@dataclass(frozen=True, slots=True)
class Search:
    """What one task is given: files as every worker sees them, threads of the search, and the effect deleted; of the candidates of other
    effects only one in `one_in` is tried."""

    model: Path
    fitted: Path
    held: Path
    out: Path
    threads: int
    deleted: str = ""
    one_in: int = 1


@dataclass(frozen=True, slots=True)
class Took:
    """What one search took and said; `began` and `ended` by the clock all processes of a machine share (s)."""

    began: float
    ended: float
    processor_s: float
    simulations: int
    windows: int
    restarts: int
    restarted_windows: int
    screened: str
    found: str

    @property
    def line(self) -> str:
        return (f"{self.ended - self.began:.1f} s, {self.processor_s:.1f} processor seconds; {self.simulations} simulations of "
                f"{self.windows} windows, {self.restarts} restarts of {self.restarted_windows}")  # fmt: skip


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


@contextmanager
def fewer(deleted: str, one_in: int) -> Iterator[None]:
    """Fewer candidates, chosen by their labels alone."""

    def some(rig: Rig, channels: frozenset[str]) -> list[Candidate]:
        return [each for each in candidates(rig, channels) if each.effect == deleted or crc32(each.label.encode()) % one_in == 0]

    with ExitStack() as patches:
        for module in ASKING:
            patches.enter_context(patch.object(module, "candidates", some))
        yield


def measured(search: Search) -> Took:
    """Run one search."""
    said: list[str] = []
    with counted() as (carried, restarted), fewer(search.deleted, search.one_in):
        began, processor = time.time(), time.process_time()
        settings = Settings(propose=False, workers=search.threads)
        found = find(search.model, [search.fitted], [search.held], search.out, said.append, settings)
        ended, spent = time.time(), time.process_time() - processor
    screened = next((line for line in said if line.startswith("screening")), "no candidate")
    findings, gap = found.content["findings"], found.content["gap"]
    names = ", ".join(f"{f['effect']} at {f['where']}{'' if f['confirmed'] else ' (tentative)'}" for f in findings) or "nothing"
    costs = f"hold-out {gap['holdout_before']:.3g} → {gap['holdout_after']:.3g} noise floors"
    counts = carried.calls, carried.windows, restarted.calls, restarted.windows
    return Took(began, ended, spent, *counts, screened, f"{found.verdict.word}, {names}; {costs}")


def measured_on_dask(search: Search, workers: int, verdicts: int) -> list[Took]:
    """The same search `verdicts` times on so many workers of a cluster on this machine, each of them one thread."""
    from distributed import LocalCluster  # the extra longreach[dask]

    tasks = [replace(search, out=search.out / f"{number}", threads=1) for number in range(verdicts)]
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
        executor(dask=cluster.scheduler_address) as pool,
    ):
        return [took for _, took in each(pool, measured, tasks)]
