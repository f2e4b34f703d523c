"""Simulated runs: each a log of its own, made by the daemon's loop in lockstep."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from config.errors import LongreachError, UsageError
from config.loading.load import LoadedRig, changed_rig
from config.loading.stand_in import with_simulated_devices
from config.schema.rig import Rig
from daemon.cli.simulate.outcome import RunOutcome, outcome
from daemon.cli.simulate.sweep import OF_MANEUVER, SHAPER, Case
from daemon.lockstep import run_into
from daemon.server.start_request import requested_maneuver
from gap.executor import each, executor
from servo_control.shapers.shaper_choice import with_kind


@dataclass(frozen=True, slots=True)
class Work:
    """One run. `request`: as of `start`; `log`: where its log goes; `settings` and `case`: what the user and the sweep changed."""

    rig_text: str
    rig_path: str
    request: Mapping[str, Any]
    log: Path
    seed: int
    settings: Case
    case: Case


@dataclass(frozen=True, slots=True)
class SimulatedRun:
    """What became of one run; a refusal stands in `refused` and leaves no log."""

    case: Case
    outcome: RunOutcome | None
    refused: str

    def as_dict(self) -> dict[str, Any]:
        return {"case": self.case, "outcome": self.outcome.as_dict() if self.outcome else None, "refused": self.refused or None}


def changed(work: Work, case: Case) -> tuple[LoadedRig, Mapping[str, Any]]:
    """Rig and request with the case's values: keys of the rig file, `shaper`, or `maneuver.KEY`."""
    of_rig = [f"{key}={value}" for key, value in case.items() if key != SHAPER and not key.startswith(OF_MANEUVER)]
    of_maneuver = [f"{key.removeprefix(OF_MANEUVER)}={value}" for key, value in case.items() if key.startswith(OF_MANEUVER)]
    for key, value in case.items():
        _refuse_maneuver_key(key, value, work)
    request = dict(work.request) | {"parameters": [*work.request["parameters"], *of_maneuver]}
    if SHAPER in case:
        request["shaper"] = with_kind(work.request["shaper"], case[SHAPER])
    return changed_rig(work.rig_text, work.rig_path, of_rig), request


def _refuse_maneuver_key(key: str, value: str, work: Work) -> None:
    """A key of the maneuver without its "maneuver." would be looked for in the rig file."""
    if key in (SHAPER, *Rig.model_fields) or "." in key or key not in requested_maneuver(work.request["maneuver"], [])[0]:
        return
    what, better = f"{key} is a key of the maneuver, not of the rig file", f"{OF_MANEUVER}{key}={value}"
    raise UsageError(what, where="--set", next_step=f"Write {OF_MANEUVER}{key}.", mend={f"{key}={value}": better})


def one_run(work: Work) -> SimulatedRun:
    """Simulate and measure. What refuses the run (a limit, an unstable gain) is its result, not an error."""
    try:
        return SimulatedRun(work.case, outcome(logged(work)), "")
    except LongreachError as error:
        return SimulatedRun(work.case, None, str(error))


def logged(work: Work) -> Path:
    """The log of one run. LongreachError when the rig file, the maneuver or the run is refused."""
    loaded, request = changed(work, work.settings | work.case)
    return run_into(work.log, with_simulated_devices(loaded), request, work.seed)


def all_runs(works: Sequence[Work], processes: int | None, dask: str | None, progress: Callable[[str], None]) -> list[SimulatedRun]:
    """In the order of `works`, side by side on processes of this machine or a Dask cluster."""
    found: dict[int, SimulatedRun] = {}
    with executor(processes, dask, progress) as pool:
        for number, run in each(pool, one_run, works):
            found[number] = run
            progress(f"{len(found)} of {len(works)} runs")
    return [found[number] for number in range(len(works))]
