"""The numbers of simulated runs as lines for one and as a table for a sweep."""

from __future__ import annotations

from math import isnan

from rich.table import Table

from config.loading.load import rig_from_text
from config.loading.stated_units import conversion, stated_units
from config.stated_sentences import StatedSentences
from daemon.cli.simulate.outcome import RunOutcome
from daemon.cli.simulate.runs import SimulatedRun
from recording.files.reader import read_log


def lines(outcome: RunOutcome) -> list[str]:
    """One run in words."""
    units = _units(outcome)
    found = [f"{outcome.log}: {outcome.duration_s:.2f} s"]
    for joint, one in outcome.joints.items():
        unit, factor = units[joint]
        errors = f"{factor * one.rms_error:.3g} {unit} rms, {factor * one.largest_error:.3g} {unit} at most"
        found.append(f"  {joint}: following error {errors}, {factor * one.last_error:.2g} {unit} at the end; command up to "
                     f"{one.largest_command_V:.3g} V")  # fmt: skip
    if not isnan(outcome.tip_vibration_mps2):
        found.append(f"  tip vibration 1.0 s after the moves: {outcome.tip_vibration_mps2:.3g} m/s² rms over the holds")
    return found


def table(runs: list[SimulatedRun]) -> Table:
    """A row a run, with what the sweep changed first; `below` says what does not fit into a row."""
    first = next((run.outcome for run in runs if run.outcome), None)
    units = _units(first) if first else {}
    shown = Table(header_style="bold", box=None, padding=(0, 2, 0, 0), pad_edge=False)
    shown.add_column("run", justify="right")
    for key in runs[0].case:
        shown.add_column(key.replace(".", ".\n"), no_wrap=True)
    for joint in first.joints if first else ():
        shown.add_column(f"{joint}\nrms\nerror\n{units[joint][0]}", justify="right", no_wrap=True)
        shown.add_column("largest\ncommand\nV", justify="right", no_wrap=True)
    shown.add_column("tip\nvibration\nm/s²", justify="right", no_wrap=True)
    for number, run in enumerate(runs, 1):
        shown.add_row(str(number), *run.case.values(), *_cells(run, units))
    return shown


def below(runs: list[SimulatedRun], sentences: StatedSentences) -> list[str]:
    """Where the logs are, and why a run has no numbers."""
    made = [str(run.outcome.log) for run in runs if run.outcome]
    logs = [f"logs: {made[0]} to {made[-1]}, numbered as the rows" if len(made) > 1 else f"log: {made[0]}"] if made else []
    return [*logs, *(f"run {number} refused: {sentences.text(run.refused)}" for number, run in enumerate(runs, 1) if run.outcome is None)]


def _cells(run: SimulatedRun, units: dict[str, tuple[str, float]]) -> list[str]:
    if run.outcome is None:
        return ["-"] * (2 * len(units) + 1)
    cells = []
    for joint, one in run.outcome.joints.items():
        cells += [f"{units[joint][1] * one.rms_error:.3g}", f"{one.largest_command_V:.3g}"]
    vibration = run.outcome.tip_vibration_mps2
    return [*cells, "-" if isnan(vibration) else f"{vibration:.3g}"]


def _units(outcome: RunOutcome) -> dict[str, tuple[str, float]]:
    """Joint → the unit of its travel in the rig file, and what one in SI is in it."""
    text = read_log(outcome.log).attachments["rig.yaml"].decode()
    stated, found = stated_units(text), {}
    for name, joint in rig_from_text(text).joints.items():
        si = joint.position_unit
        unit, factor, _ = conversion(si, stated.get(name, si)) or (si, 1.0, 0.0)
        found[name] = (unit, factor)
    return found
