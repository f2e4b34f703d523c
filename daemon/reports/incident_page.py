"""The page of a fault: first cause, consequences in order, commands before it, the checks then, what to look at, the last 30 s."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from html import escape
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from config.whole_file import write_whole
from daemon.checks.check_history import Change
from daemon.reports.incident import AFTER_S, BEFORE_S, Incident, IncidentStep, faults_of, incident_of, incident_page_of
from daemon.reports.stated_log import sentences_of, units_of_checks
from daemon.server.stated_values import Units, as_stated
from recording.evaluation.chosen_signals import ChosenSignal, column_conversions, in_unit
from recording.evaluation.cut_out import cut_out
from recording.evaluation.page import folded, page, paragraph, table, verdict
from recording.evaluation.panels import Line, Panel, by_unit, svg
from recording.files.reader import Log, read_log
from recording.files.recordings import cut_out_of

CLOSE_S = 0.5  # before and after the first cause: every cycle is drawn
SHOWN = ("target", "reference", "position", "command_V", "supply_pressure_Pa", "return_pressure_Pa", "pressure_a_Pa", "pressure_b_Pa")
FAILED_PANELS = 4


class Written(NamedTuple):
    """`page` of a fault, and `log`: the last 30 s before it as a log of its own."""

    page: Path
    log: Path


def write_incidents(path: Path, number: int | None = None) -> list[Written]:
    """Beside the log for each of its faults, or for one. LogError where there is none."""
    log = read_log(path)
    written = []
    for each in [number] if number else range(1, max(len(faults_of(log)), 1) + 1):
        incident, out = incident_of(log, each), Written(incident_page_of(path, each), cut_out_of(path, each))
        executable = cut_out(log, incident.t_s - BEFORE_S, incident.t_s + AFTER_S, out.log)
        write_whole(out.page, incident_page(log, incident, out.log, executable))
        written.append(out)
    return written


def incident_page(log: Log, incident: Incident, own_log: Path, executable: bool) -> str:
    """`own_log`: the last 30 s before the fault; `executable`: whether its controller can be executed again."""
    title, units = f"Fault {incident.number} of {log.path.name}", units_of_checks(log, incident.moment.checks)
    incident = _stated(log, incident)
    parts = [
        _head(log, incident), _look_at(incident), _steps(incident), _commands(incident), _pictures(incident.log, incident, units),
        _checks(incident, units), _log(log, incident, own_log, executable),
    ]  # fmt: skip
    return page(title, parts)


def _stated(log: Log, incident: Incident) -> Incident:
    """Its sentences in the units of the log's rig file."""
    say = sentences_of(log).text
    steps, commands = (tuple(replace(step, text=say(step.text)) for step in each) for each in (incident.steps, incident.commands))
    first = incident.first and replace(incident.first, text=say(incident.first.text))
    return replace(incident, steps=steps, commands=commands, first=first, fault=replace(incident.fault, text=say(incident.fault.text)))


def _head(log: Log, incident: Incident) -> str:
    rig = log.metadata.get("recording", {}).get("rig_name", "unknown rig")
    when = np.datetime64(int(incident.log.time_ns[incident.row]), "ns").astype("datetime64[ms]")
    before_ms = 1e3 * (incident.t_s - incident.cause_t_s)
    lead = f"{before_ms:.0f} ms before the fault" if before_ms > 0.5 else "in the cycle of the fault"
    mode = f"The daemon's own words, at t_s = {incident.t_s:.3f} s: {incident.fault.text}"
    return (
        f"<h1>Fault on {escape(rig)}</h1>"
        + paragraph(f"{log.path.name}, {when} UTC, cycle {incident.fault.cycle}.")
        + verdict(False, f"First cause, {lead}", incident.cause)
        + paragraph(mode)
        + (paragraph(f"The log reaches back {incident.reaches_back_s:.1f} s; no recording that it continues stands beside it.", "small")
           if incident.reaches_back_s < BEFORE_S - 0.1 else "")
    )  # fmt: skip


def _look_at(incident: Incident) -> str:
    """The failed checks of that moment with what to do and where it is explained."""
    failed = [check for check in incident.moment.checks if check["ok"] is False]
    rows = [[check["name"], check["next_step"], check["page"]] for check in failed]
    if incident.first is not None and incident.first.check.name not in {row[0] for row in rows}:
        rows.insert(0, [incident.first.check.name, incident.first.check.next_step, incident.first.check.page])
    if not rows:
        said = "No check that can be asked of the log's columns failed: the cause is in the fault's own words above."
        return (
            "<h2>What to look at</h2>" + paragraph(said) + paragraph("Symptoms: docs/guide/operate/troubleshooting.md#it-stopped-in-a-run")
        )
    return "<h2>What to look at</h2>" + table(["check", "what to do", "explained in"], rows)


def _steps(incident: Incident) -> str:
    shown = [step for step in incident.steps if step.t_s >= incident.cause_t_s - 1e-9]
    earlier = [step for step in incident.steps if step.t_s < incident.cause_t_s - 1e-9]
    before = folded(f"The {len(earlier)} things before", _table(earlier, incident)) if earlier else ""
    return "<h2>From the first cause on</h2>" + _table(shown, incident) + before


def _commands(incident: Incident) -> str:
    if not incident.commands:
        return "<h2>Commands before it</h2>" + paragraph(f"None in the last {incident.reaches_back_s:.0f} s.")
    return "<h2>Commands before it</h2>" + _table(incident.commands, incident)


def _table(steps: Sequence[IncidentStep], incident: Incident) -> str:
    rows = [[f"{1e3 * (step.t_s - incident.t_s):+.0f}", f"{step.t_s:.3f}", step.what, step.text, step.page] for step in steps]
    return table(["to the fault / ms", "t_s", "", "", "explained in"], rows, [step.bad for step in steps])


def _pictures(log: Log, incident: Incident, of_checks: Units) -> str:
    units = column_conversions(log)
    zero = incident.t_s
    whole = (incident.t_s - BEFORE_S, incident.t_s + AFTER_S)
    close = (incident.cause_t_s - CLOSE_S, incident.cause_t_s + CLOSE_S)
    parts = [f"<h2>The last {BEFORE_S:.0f} s</h2>"]
    failed = _failed_panels(log, incident, whole, of_checks)
    if failed:
        parts.append(svg(failed, "numbers of the checks that failed, with their limits dashed", "time to the fault / s"))
    parts.append(svg(_panels(log, whole, units, zero), "joints, commands, pressures and tip before the fault", "time to the fault / s"))
    parts.append(f"<h2>Around the first cause, every cycle of {2 * CLOSE_S:g} s</h2>")
    parts.append(svg(_panels(log, close, units, zero), "the same around the first cause", "time to the fault / s"))
    return "".join(parts)


def _failed_panels(log: Log, incident: Incident, span: tuple[float, float], units: Units) -> list[Panel]:
    """The number of each check that failed, first cause first, with its limits."""
    order = dict.fromkeys([*([incident.first.check.name] if incident.first else []), *incident.history.numbers])
    changes: dict[str, Change] = {change.check.name: change for change in reversed(incident.history.changes)}
    rows = slice(incident.history.start, incident.history.start + len(next(iter(incident.history.numbers.values()), np.array([]))))
    t = np.asarray(log.columns["t_s"][rows], dtype=np.float64)
    inside = (t >= span[0]) & (t <= span[1])
    panels = []
    for name in list(order)[:FAILED_PANELS]:
        check, values = changes[name].check, incident.history.numbers[name]
        unit, factor, offset = units.get(name, (check.unit, 1.0, 0.0))
        limits = [factor * limit + offset for limit in (check.low, check.high) if isfinite(limit)]
        x = t[inside] - incident.t_s
        lines = [
            Line("value", x, factor * values[inside] + offset),
            *(Line("limit", x[[0, -1]], np.full(2, limit), dashed=True) for limit in limits),
        ]
        panels.append(Panel(name, unit, tuple(lines), marks=(0.0,)))
    return panels


def _panels(log: Log, span: tuple[float, float], units: Units, zero: float) -> list[Panel]:
    t = log.columns["t_s"]
    rows = slice(int(np.searchsorted(t, span[0])), int(np.searchsorted(t, span[1], side="right")))
    names = [name for name in log.columns if name.startswith("tip.") or name.rpartition(".")[2] in SHOWN]
    names = [name for name in names if not name.endswith(("_raw", "_age_s"))]
    signals: list[ChosenSignal] = [in_unit(log, name, rows, units) for name in names]
    there = [signal for signal in signals if np.any(np.isfinite(signal.values))]
    return [Panel(panel.title, panel.unit, panel.lines, marks=(0.0,)) for panel in by_unit(there, zero)]


def _checks(incident: Incident, units: Units) -> str:
    order = {False: 0, True: 1, None: 2}
    checks = sorted((as_stated(check, units) for check in incident.moment.checks), key=lambda check: order[check["ok"]])
    rows = [
        [_word(check["ok"]), check["name"], _number(check["value"]), check["unit"], check["limit"], check["source"]] for check in checks
    ]
    what = "The checks in the cycle of the fault, from the log's columns; “unknown” is what no column holds."
    head = ["", "check", "value", "unit", "limit", "source"]
    return "<h2>Checks at that moment</h2>" + paragraph(what, "small") + table(head, rows, [check["ok"] is False for check in checks])


def _log(log: Log, incident: Incident, own_log: Path, executable: bool) -> str:
    name = own_log.name
    what = f"Every cycle from {BEFORE_S:.0f} s before the fault to {AFTER_S:.0f} s after it, with rig file and requests, is a log"
    whole = "" if executable else " The controller of that log cannot be executed again."
    again = [
        f"longreach why {name} --at {incident.cause_t_s:.3f}", f"longreach log plot {name} --signals '*.position' '*.command_V'",
        *([f"longreach replay {name}"] if executable else []),
    ]  # fmt: skip
    return (
        "<h2>Behind it</h2>"
        + paragraph(f"{what} of its own: {name}, beside this page, cut out of {log.path.name}.{whole}")
        + paragraph(f"To look closer: {'; '.join(again)}")
    )


def _word(ok: bool | None) -> str:
    return "unknown" if ok is None else "ok" if ok else "NO"


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"
