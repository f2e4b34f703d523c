"""The page of one run: reference and actual, the tip in its holds, predicted beside measured, oil, timing, validity; beside the last valid
run of the same maneuver and the same run on the simulated rig of the log."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path

import numpy as np

from config.errors import LogError, LongreachError, WriteError
from config.whole_file import refuse_unwritable, write_whole
from daemon.reports.earlier_run import last_valid_run
from daemon.reports.simulated_run import simulated_run
from daemon.reports.stated_log import sentences_of
from daemon.reports.trace import BAND_HZ, Trace
from recording.evaluation.chosen_signals import column_conversions
from recording.evaluation.page import folded, page, paragraph, table, verdict
from recording.evaluation.panels import Line, Panel, by_unit, svg
from recording.evaluation.vibration import TIP, rms_mps2
from recording.files.check import check_log
from recording.files.info import run_facts
from recording.files.reader import Log, read_log
from recording.format.event import Level
from tuning.shaper_choice.shaped_moves import shaped_moves

SIMULATED, EARLIER = "simulated", "last valid run"
HOLDS = 4  # spectra shown

Say = Callable[[str], None]


def write_reports(path: Path, runs: Sequence[int] | None = None, simulate: bool = True, say: Say = lambda line: None) -> list[Path]:
    """A page beside the log for each of its runs (or `runs`): LOG-run-1.html. `say` gets a line before each step that takes time.

    LogError where the log has no such run, or none at all; WriteError where nothing can be written beside it.
    """
    log = read_log(path)
    wanted = runs or [each.number for each in run_facts(log)]
    if not wanted:
        advice = f"Standby recordings and data of another system have none; `longreach log plot {shlex.quote(str(path))}` shows them."
        raise LogError("the log holds no run", where=str(path), next_step=advice)
    _refuse_unwritable(path)
    pages = []
    for run in wanted:
        out = run_page_of(path, run)
        say(f"making the report of run {run}")
        write_whole(out, run_page(log, run, simulate, say))
        pages.append(out)
    return pages


def _refuse_unwritable(log: Path) -> None:
    """WriteError before the simulation and not after it: a page stands beside its log, and there is no other place to choose."""
    try:
        refuse_unwritable(log.parent)
    except OSError as error:
        who = f"`ls -ld {shlex.quote(str(log.parent))}` shows who may write here."
        advice = f"A page stands beside its log: copy {log.name} to a folder of your own, and name the copy. {who}"
        reason = error.strerror or str(error)
        raise WriteError("no page can be written here", value=reason, where=str(log.parent), next_step=advice) from error


def run_page_of(log: Path, run: int) -> Path:
    """Where the page of a run stands: beside the log."""
    return log.with_name(f"{log.stem}-run-{run}.html")


def run_page(log: Log, run: int, simulate: bool = True, say: Say = lambda line: None) -> str:
    """The page. LogError for a run that the log does not have."""
    units = column_conversions(log)
    trace = Trace("", log, run, units)
    notes: list[str] = []
    others = [each for each in (_simulated(trace, simulate, say, notes), _earlier(trace, notes)) if each is not None]
    say("drawing")
    parts = [
        _head(trace, others, notes), _vibration(trace, others), _joints(trace, others), _tip(trace, others), _spectra(trace, others),
        _oil(trace), _timing(trace), _events(trace), _facts(trace),
    ]  # fmt: skip
    return page(f"{trace.facts.maneuver}, run {run} of {log.path.name}", parts)


def _simulated(trace: Trace, wanted: bool, say: Say, notes: list[str]) -> Trace | None:
    if not wanted:
        return None
    say("running it again on the simulated rig of the log")
    try:
        return Trace(SIMULATED, simulated_run(trace.log, trace.run), trace.run, trace.units)
    except (LongreachError, KeyError) as error:
        notes.append(f"Not simulated: {error}")
        return None


def _earlier(trace: Trace, notes: list[str]) -> Trace | None:
    found = last_valid_run(trace.log, trace.run, trace.facts.maneuver)
    if found is None:
        notes.append(f"No earlier valid run of {trace.facts.maneuver} stands beside this log.")
        return None
    path, run = found
    notes.append(f"Last valid run of {trace.facts.maneuver}: {path.name}, run {run}.")
    log = trace.log if path == trace.log.path else read_log(path)
    return Trace(EARLIER, log, run, trace.units)


def _head(trace: Trace, others: Sequence[Trace], notes: Sequence[str]) -> str:
    facts, about = trace.facts, trace.log.metadata.get("recording", {})
    when = np.datetime64(int(trace.log.time_ns[trace.rows.start]), "ns").astype("datetime64[s]")
    reason = sentences_of(trace.log).text(facts.reason)
    said = verdict(facts.valid, "valid" if facts.valid else "not valid", reason or _left(trace, others))
    open_note = "" if trace.log.complete else paragraph(f"The log as it was when this page was made: {trace.log.cut_text}", "small")
    return (
        f"<h1>{escape(facts.maneuver)} with {escape(facts.shaper)} on {escape(about.get('rig_name', 'unknown rig'))}</h1>"
        + paragraph(f"Run {trace.run} of {trace.log.path.name}, {when} UTC, {facts.duration_s:.1f} s, {_clock(about)}.")
        + said
        + "".join(paragraph(note, "small") for note in notes)
        + open_note
    )


def _clock(about: dict[str, str]) -> str:
    return "in lockstep (simulated time)" if about.get("clock") == "lockstep" else "on the wall clock"


def _left(trace: Trace, others: Sequence[Trace]) -> str:
    """What vibration was left, in a sentence."""
    if not trace.holds:
        return ""
    rest = "".join(f", {other.name} {rms_mps2(other.holds):.3f}" for other in others if other.holds)
    return f"the tip keeps {rms_mps2(trace.holds):.3f} m/s² 1.0 s after its moves (rms){rest}"


def _vibration(trace: Trace, others: Sequence[Trace]) -> str:
    if not trace.holds:
        return ""
    predicted = {move.move: move for move in shaped_moves(trace.log, [trace.run])}
    head = ["hold after", "measured", *(each.name for each in others), "predicted, whole rig", "predicted, ideal joints", "frequency / Hz",
            "later than planned / s", "predicted / s"]  # fmt: skip
    rows = []
    for number, hold in enumerate(trace.holds):
        move = predicted.get(hold.move)
        beside = [each.holds[number].amplitude_mps2 if number < len(each.holds) else None for each in others]
        numbers = (None,) * 4 if move is None else (move.coupled_mps2, move.ideal_mps2, move.measured_late_s, move.predicted_late_s)
        cells = [hold.amplitude_mps2, *beside, *numbers[:2]]
        rows.append([hold.move, *map(_three, cells), f"{hold.frequency_Hz:.2f}", *map(_three, numbers[2:])])
    return (
        "<h2>Vibration left, m/s²</h2>"
        + table(head, rows)
        + paragraph("Amplitude of the tip 1.0 s after the planned end of a move.", "small")
    )


def _joints(trace: Trace, others: Sequence[Trace]) -> str:
    parts = ["<h2>Joints</h2>"]
    for joint in trace.log.layout.joint_names:
        measured = trace.signal(f"{joint}.position")
        unit = measured.unit if measured is not None else ""
        position = [trace.line(f"{joint}.target", dashed=True), trace.line(f"{joint}.reference"), trace.line(f"{joint}.position")]
        panels = [
            Panel(f"{joint} position", unit, _lines(position + [each.line(f"{joint}.position") for each in others]), trace.shaded()),
            Panel(f"{joint} error (reference − position)", unit, _lines([each.error(joint) for each in (trace, *others)]), trace.shaded()),
            Panel(f"{joint} command", "V", _lines([each.line(f"{joint}.command_V") for each in (trace, *others)]), trace.shaded()),
        ]
        parts.append(_drawn(panels, f"{joint}: position, error and command over time"))
        parts.append(_error_table(trace, others, joint, unit))
    return "".join(parts)


def _error_table(trace: Trace, others: Sequence[Trace], joint: str, unit: str) -> str:
    rows = []
    for each in (trace, *others):
        line = each.error(joint)
        if line is None:
            continue
        running = line.y[(line.x >= 0.0) & (line.x <= each.end_s - each.start_s) & np.isfinite(line.y)]
        if len(running):
            rms = float(np.sqrt(np.mean(running**2)))
            rows.append([each.name or "this run", f"{rms:.4g}", f"{np.max(np.abs(running)):.4g}", f"{running[-1]:.4g}"])
    return table([f"{joint} error / {unit}", "rms", "largest", "at the end"], rows)


def _tip(trace: Trace, others: Sequence[Trace]) -> str:
    panels = []
    for column, name in ((TIP, "tip acceleration"), ("tip.deflection_m", "tip deflection")):
        signal = trace.signal(column)
        if signal is not None:
            lines = _lines([each.line(column) for each in (trace, *others)])
            panels.append(Panel(name, signal.unit, lines, trace.shaded()))
    return "<h2>Tip</h2>" + _drawn(panels, "tip acceleration and deflection over time; holds are shaded") if panels else ""


def _spectra(trace: Trace, others: Sequence[Trace]) -> str:
    signal = trace.signal(TIP)
    panels = []
    for number, hold in enumerate(trace.holds[:HOLDS]):
        lines = _lines([each.spectrum(number) for each in (trace, *others)])
        panels.append(Panel(f"hold after {hold.move}", signal.unit if signal else "", lines, log_y=True))
    what = f"spectra of the tip acceleration in the holds, {BAND_HZ[0]:g} to {BAND_HZ[1]:g} Hz"
    return "<h2>Spectra in the holds</h2>" + _drawn(panels, what, "frequency / Hz") if panels else ""


def _oil(trace: Trace) -> str:
    names = [name for name in trace.log.columns if name.endswith(("_pressure_Pa", "_temperature_C", "pressure_a_Pa", "pressure_b_Pa"))]
    signals = [signal for signal in map(trace.signal, names) if signal is not None]
    panels = by_unit(signals, trace.start_s)
    return "<h2>Pressures and temperatures</h2>" + _drawn(panels, "pressures and temperatures over time") if panels else ""


def _timing(trace: Trace) -> str:
    columns, rows = trace.log.columns, []
    for phase in ("late", "read", "compute", "write"):
        values = columns[f"{phase}_us"][trace.rows]
        values = values[np.isfinite(values)]
        if len(values):
            rows.append([phase, *(f"{figure:.0f}" for figure in np.quantile(values, (0.5, 0.99, 1.0)))])
    if not rows:
        return ""
    first, last = trace.rows.start, min(trace.rows.stop, trace.log.cycles) - 1
    counts = [f"{name}: {int(columns[name][last]) - int(columns[name][first])}" for name in ("overruns", "drops")]
    skipped = int(np.sum(np.diff(columns["cycle"][trace.rows].astype(np.int64)) - 1))
    grade = trace.log.metadata.get("closing", {}).get("grade", "")
    said = "; ".join([*counts, f"cycles missing: {skipped}", *([f"grade of the recording: {grade}"] if grade else [])])
    return "<h2>Timing</h2>" + table(["phase / µs", "p50", "p99", "largest"], rows) + paragraph(f"During the run: {said}.")


def _events(trace: Trace) -> str:
    first, last = (trace.log.columns["cycle"][row] for row in (trace.rows.start, min(trace.rows.stop, trace.log.cycles) - 1))
    met = [event for event in trace.log.events if first <= event.cycle <= last and event.name != "link"]
    say = sentences_of(trace.log).text
    rows = [[f"{event.t_s - trace.start_s:.3f}", event.name, say(event.text)] for event in met]
    return "<h2>Events</h2>" + table(["t / s", "", ""], rows, [event.level >= Level.WARNING for event in met]) if rows else ""


def _facts(trace: Trace) -> str:
    log = trace.log
    about = [[key, value] for key, value in log.metadata.get("recording", {}).items()]
    request = [[key, value] for key, value in trace.request.items()]
    checks = [[finding.name, finding.grade, finding.text] for finding in check_log(log.path).findings]
    again = f"longreach replay {log.path.name}; longreach log plot {log.path.name}; longreach why {log.path.name} --at {trace.end_s:.3f}"
    return (
        "<h2>Behind it</h2>"
        + paragraph(f"Time is 0 where the program begins: t_s = {trace.start_s:.3f} s of the log. To look closer: {again}")
        + folded("Is the log fit for use", table(["check", "", ""], checks))
        + folded("The request, as logged (SI)", table(["", ""], request))
        + folded("The recording", table(["", ""], about))
    )


def _lines(lines: Sequence[Line | None]) -> tuple[Line, ...]:
    return tuple(line for line in lines if line is not None)


def _drawn(panels: Sequence[Panel], what: str, x_label: str = "time since the program began / s") -> str:
    shown = [panel for panel in panels if panel.lines]
    return svg(shown, what, x_label) if shown else ""


def _three(value: float | None) -> str | None:
    return None if value is None or np.isnan(value) else f"{value:.3f}"
