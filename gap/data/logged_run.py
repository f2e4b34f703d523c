"""The run that a log holds, so that it can be run again: its request, or where that is not known the reference it followed.

An MCAP log carries the request. A table does not: its run can be given (a maneuver file, or the request as JSON), or is taken from its
columns `J.reference` and `J.reference_rate`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from config.loading.load import load_maneuver
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from gap.data.measured import Array
from recording.files.reader import read_log
from recording.importing.read_table import read_table
from recording.importing.source_columns import columns_by_name
from servo_control.path.pieces import Kind, Sample
from servo_control.path.program import Program
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.shapers.shaper_setup import ShaperSetup
from servo_control.signals import Mode

NEITHER = (
    "The hold-out is a table without the run's request and without the columns {missing}, so the controller cannot be run again. Give the "
    "maneuver with --request, or log the reference."
)
NO_RUN = "The hold-out holds no run of a maneuver, so the controller cannot be run again."


@dataclass(frozen=True, slots=True)
class LoggedRun:
    """Columns of the log at the loop's rate, from the run's first row on; from the log's where `begun` is False: nothing in the table
    says when the run began. `request`: None where only the reference is known."""

    columns: Mapping[str, Array]
    begun: bool
    request: RunRequest | None

    def start(self, rig: Rig) -> list[float]:
        return [float(self.columns[f"{joint}.position"][0]) for joint in rig.joints]

    def planned(self, rig: Rig) -> RunPlan:
        """ManeuverError when this rig cannot run it."""
        if self.request is not None:
            return plan_run(rig, self.request)
        piece = FollowedReference(self.columns, rig)
        shaper = ShaperSetup("none", (), 1.0 / rig.loop.rate_Hz)
        request = RunRequest(1, {"name": "logged reference", "kind": "logged_reference"})
        return RunPlan(request, Program([piece]), shaper, tuple(rig.joints), piece.at(0.0)[0], piece.duration_s, 0.0, ())


class FollowedReference:
    """A piece of a program: the references that a log holds, as they were after shaping."""

    __slots__ = ("_period_s", "_positions", "_rates", "_zero", "duration_s", "kind", "name")

    def __init__(self, columns: Mapping[str, Array], rig: Rig) -> None:
        self.name, self.kind = "logged reference", _MOVE
        self._period_s = 1.0 / rig.loop.rate_Hz
        self._positions = np.column_stack([columns[f"{joint}.reference"] for joint in rig.joints])
        self._rates = np.column_stack([_rate(columns, joint, self._period_s) for joint in rig.joints])
        self._zero = (0.0,) * len(rig.joints)
        self.duration_s = (len(self._positions) - 1) * self._period_s

    def at(self, t: float) -> Sample:
        """Of the row at t: it is held until the next. Volts are not known; those of a wave on the command are missing."""
        row = min(round(t / self._period_s), len(self._positions) - 1)
        return tuple(self._positions[row].tolist()), tuple(self._rates[row].tolist()), self._zero, self._zero


_MOVE: Kind = "move"


def logged_run(path: Path, rig: Rig, given: Path | None) -> LoggedRun | str:
    """The log's first run, or why there is none to run again. `given`: maneuver file or request (JSON) that goes before the log's own."""
    if path.suffix.lower() == ".mcap":
        log = read_log(path)
        columns = {name: np.asarray(values, dtype=np.float64) for name, values in log.columns.items()}
        attached = next((log.attachments[name] for name in sorted(log.attachments) if name.startswith("run-")), None)
    else:
        columns, attached = columns_by_name(read_table(path), rig)[1], None
    if attached is not None and RunRequest.from_json(attached).by_hand:
        attached = None  # its reference is all that a program could say
    begun = "mode" in columns and bool(np.any(columns["mode"] == int(Mode.RUNNING)))
    if path.suffix.lower() == ".mcap" and not begun:
        return NO_RUN
    rows = np.flatnonzero(columns["mode"] == int(Mode.RUNNING)) if begun else np.arange(len(columns["t_s"]))
    columns = _at_loop_rate({name: values[rows[0] : rows[-1] + 1] for name, values in columns.items()}, rig)
    if given is None and attached is None:
        missing = [f"{joint}.reference" for joint in rig.joints if f"{joint}.reference" not in columns]
        return NEITHER.format(missing=", ".join(missing)) if missing else LoggedRun(columns, True, None)
    run = LoggedRun(columns, begun, RunRequest.from_json(attached) if given is None and attached else None)
    return run if run.request else replace(run, request=given_request(given, run.start(rig)) if given else None)


def given_request(path: Path, start: list[float]) -> RunRequest:
    """The run of a maneuver file or a request (JSON). ManeuverError, or OSError, for a file that is neither."""
    if path.suffix.lower() == ".json":
        request = RunRequest.from_json(path.read_text())
        return request if request.start_position else replace(request, start_position=start)
    return RunRequest(1, maneuver_content(load_maneuver(path).maneuver), start_position=start, approach=True)


def _at_loop_rate(columns: Mapping[str, Array], rig: Rig) -> dict[str, Array]:
    """Every column that has values, on the loop's grid."""
    t = columns["t_s"] - columns["t_s"][0]
    grid = np.arange(int(np.floor(t[-1] * rig.loop.rate_Hz + 0.5)) + 1) / rig.loop.rate_Hz
    found = {}
    for name, values in columns.items():
        there = np.isfinite(values)
        if there.any():
            found[name] = np.interp(grid, t[there], values[there])
    return found


def _rate(columns: Mapping[str, Array], joint: str, period_s: float) -> Array:
    logged = columns.get(f"{joint}.reference_rate")
    return logged if logged is not None else np.gradient(columns[f"{joint}.reference"], period_s)
