"""report.html: one file that shows where the gap was, what closed it, and what could not be seen. Every cost is of the hold-out."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from config.loading.load import rig_from_text
from config.readable import number, probability
from config.whole_file import write_whole
from gap.outcome.file_units import FileUnits
from gap.outcome.found import Found
from gap.remainder.remainder import sentence
from gap.report import plots
from gap.report.constants_table import constants_table
from gap.report.headline import blind_values, gap_line, grade, held_lines, lead_line, look_alikes, pulled_lines, values, zero_lines
from gap.report.kept_sentence import kept_sentence
from gap.report.reliability import LEAD, how_often_right, places
from gap.report.replay import SMOOTH_S, replays
from gap.report.shown import fingerprints, first_and_blind, of_channel, region_text, stages, telling_channel
from gap.report.unseen import Unseen
from recording.evaluation.page import page, paragraph, table


def write_report(found: Found, path: Path, unseen: Sequence[Unseen] = (), request: Path | None = None, si: bool = False) -> None:
    """Write the page, its first screen by itself, in the units of the rig file (`si`: in SI). `request`: the first hold-out's run, where
    that log does not hold it."""
    units = FileUnits(found.rig.text, si)
    parts = [_first_screen(found, units), _findings(found, units), _next(found), _places(found, units), _steps(found),
             _remainder(found, units), _unseen(unseen), _fingerprints(found, units), _spectra(found),
             _replay(found, request, units), constants_table(found, units), _not_seen(found, units), _diff(found),
             _inputs(found)]  # fmt: skip
    write_whole(path, page(f"{found.rig.rig.name}: {found.verdict.word}", parts))


def _first_screen(found: Found, units: FileUnits) -> str:
    """Verdict, names with values, the numbers before and after, and the picture."""
    state = "" if found.verdict.confirmed else " open"
    said = f'<p class="verdict{state}"><b>{found.verdict.word}</b>: {escape(units.sentences.text(found.verdict.why))}</p>'
    names = _names(found.content["findings"], units)
    lines = [
        *(lead_line(item, units) for item in found.content["leads"]),
        gap_line(found.content),
        *pulled_lines(found.content, units),
        *held_lines(found.content, units),
    ]
    channel = telling_channel(found)
    name = found.channels[channel]
    picture = plots.before_and_after(first_and_blind(found), channel, name, of_channel(found, name, units))
    zeros = "".join(map(paragraph, zero_lines(found.content, units)))
    inside = f"<h1>{escape(found.rig.rig.name)}</h1>{said}{zeros}{names}{''.join(map(paragraph, lines))}{picture}"
    return f'<section class="first">{inside}</section>'


def _names(items: Sequence[dict[str, Any]], units: FileUnits) -> str:
    """A row a name; where the values are those of all logs, with those of the fit logs alone."""
    rows = [
        [f"{item['effect']} at {item['where']}", grade(item, units), values(item, units), look_alikes(item) or "none"] for item in items
    ]
    head, blind = ["missing effect", "", "value (95 %)", "look-alikes"], [blind_values(item, units) for item in items]
    if any(blind):
        head.insert(3, "by the fit logs alone")
        rows = [[*row[:3], value, row[3]] for row, value in zip(rows, blind, strict=True)]
    return table(head, rows) if rows else ""


def _findings(found: Found, units: FileUnits) -> str:
    """What each name rests on, and what was odd about the data."""
    warnings = "".join(paragraph(f"Data: {units.sentences.text(problem.text())}", "small") for problem in found.problems)
    tried = [*found.content["leads"], *found.content["findings"]]
    rows, notes = [], []
    for item, place in zip(tried, places(found.verdict.word, [item.get("probability", 0.0) for item in tried]), strict=True):
        name = f"{item['effect']} at {item['where']}" + ("" if item in found.content["findings"] else " (not named, not in the file)")
        alike = ", ".join(f"{x['effect']} at {x['where']} (gain {_short(x['holdout_gain'])})" for x in item["look_alikes"]) or "none"
        rows.append([name, item["equation"], _short(item["holdout_gain"]), _short(item["t"]), alike])
        notes.append(paragraph(f"{name}: {item['fingerprint']} {_rests_on(item, place)}"))
    if not rows:
        return "<h2>Findings</h2>" + paragraph("No missing effect is named.") + warnings
    return "<h2>Findings</h2>" + table(["effect", "equation", "gain", "t", "look-alikes"], rows) + "".join(notes) + warnings


def _rests_on(item: dict[str, Any], place: str) -> str:
    """A name's probability, and what either log says of it where the other one is fitted."""
    if "probability" not in item:
        return "Read off the logs, not fitted."
    within = " if only known effects act" if place == LEAD else ""
    sure = f"Probability {probability(item['probability'])}{within}. {how_often_right(item['probability'], place)}".rstrip()
    if "votes" not in item:
        return sure
    by = item["votes"]
    votes = f"the hold-out {by['holdout']:+.1f}, the fit logs fitted; the fit logs {by['fit_logs']:+.1f}, the hold-out fitted"
    return f"{sure} Votes (ln): {votes}."


def _short(value: float | None) -> str:
    return "" if value is None else number(float(value))


def _next(found: Found) -> str:
    proposal = found.content["next_maneuver"]
    if not proposal:
        return ""
    changes = ", ".join(f"{key}: {value}" for key, value in proposal["parameters"].items())
    what = f"{proposal['name']} ({changes})" if changes else proposal["name"]
    return "<h2>Next maneuver</h2>" + paragraph(f"{' or '.join(proposal['separates'])}: {what}: {proposal['why']}.")


def _places(found: Found, units: FileUnits) -> str:
    rows = [
        [p.channel, p.equation, region_text(p, found.rig.rig, units), f"{p.band_Hz[0]:g} to {p.band_Hz[1]:g}", f"{p.share:.0%}"]
        for p in found.places
    ]
    sizes = []
    for name, c in found.content["gap"]["channels"].items():
        shown = of_channel(found, name, units)
        sizes.append([name, *(number(float(shown.factor * c[side])) for side in ("before", "after")), shown.unit])
    where = (
        table(["channel", "equation", "region", "band (Hz)", "share of the gap"], rows) if rows else paragraph("Nothing above the noise.")
    )
    return "<h2>Where</h2>" + where + "<h3>Error in each channel (rms)</h3>" + table(["channel", "before", "after", "unit"], sizes)


def _steps(found: Found) -> str:
    """The cost step by step."""
    return f"<h2>Gap, step by step</h2>{plots.waterfall(stages(found), found.channels)}"


def _remainder(found: Found, units: FileUnits) -> str:
    """What is left without a name, and whether the improved rig file has it."""
    rest = found.content["remainder"]
    if not rest:
        return ""
    equation = rest["discrepancy"]
    picture = plots.carried(equation) if equation and equation["carried_by"] else ""
    return "<h2>What is left</h2>" + paragraph(units.sentences.text(f"{sentence(rest)} {kept_sentence(rest)}")) + picture


def _unseen(logs: Sequence[Unseen]) -> str:
    if not logs:
        return ""
    rows = [[u.log.path.name, _cost(u.before, u.before_ci95), _cost(u.after, u.after_ci95)] for u in logs]
    said = "These logs fitted nothing and decided nothing. Costs in noise floors."
    return "<h2>Logs never used</h2>" + paragraph(said) + table(["log", "rig file", "improved"], rows)


def _cost(value: float, ci95: tuple[float, float]) -> str:
    return f"{value:.4g} ({ci95[0]:.3g} to {ci95[1]:.3g})"


def _fingerprints(found: Found, units: FileUnits) -> str:
    pictures = [
        (label, plots.fingerprint(found.nominal, found.final, found.channels.index(what.channel), what, found.rig.rig, units))
        for label, what in fingerprints(found)
    ]
    return "".join(f"<h2>Fingerprint: {escape(label)}</h2>{picture}" for label, picture in pictures)


def _spectra(found: Found) -> str:
    channel = telling_channel(found)
    name = found.channels[channel]
    return f"<h2>Spectrum of what is left of {escape(name)}</h2>" + plots.spectra(found.nominal, found.final, channel, name)


def _replay(found: Found, request: Path | None, units: FileUnits) -> str:
    """The first hold-out log's run under the real controller, from the reference."""
    title = "<h2>Closed-loop replay</h2>"
    improved = rig_from_text(found.improved_text, "improved rig.yaml")
    replayed = replays(found.state.holdouts[0].log.path, found.rig.rig, improved, request)
    if isinstance(replayed, str):
        return title + paragraph(replayed)
    said = (
        f"The hold-out's run simulated with the controller, from its reference alone; means over {SMOOTH_S * 1e3:.0f} ms. Difference, rms:"
    )
    if found.with_all_logs:
        said = f"The improved file's constants are those of all logs, this one among them. {said}"
    shown = [units.channel(r.joint, r.unit) for r in replayed]
    rows = [
        [r.joint, *(f"{v:.3g}" for v in r.rms()[:2]), *(f"{of.factor * v:.3g} {of.unit}" for v in r.rms()[2:])]
        for r, of in zip(replayed, shown, strict=True)
    ]
    head = ["joint", "command before (V)", "command after (V)", "tracking error before", "tracking error after"]
    pictures = "".join(plots.closed_loop_replay(r, of) for r, of in zip(replayed, shown, strict=True))
    return title + paragraph(said) + table(head, rows) + pictures


def _not_seen(found: Found, units: FileUnits) -> str:
    rows = [
        [
            _suspect(r, units),
            r["where"],
            r["parameter"],
            units.channel(r["where"], r["unit"]).text(r["smallest_visible"]),
            _assumed(r, units),
        ]
        for r in found.content["not_seen"]
    ]
    said = "Effects that were looked for and not named, with the smallest size that these logs would have shown, as the search reckons it."
    said += " From that size on their probability would have been 0.5 and more; of a number of the rig file, from so large a change on."
    said += " Its other numbers are then as assumed: with others the size may be another."
    return "<h2>Not seen</h2>" + paragraph(said) + table(["effect", "where", "parameter", "smallest visible", "assumed"], rows)


def _assumed(row: dict[str, Any], units: FileUnits) -> str:
    return ", ".join(f"{key} {units.channel(row['where'], one['unit']).text(one['value'])}" for key, one in row["assumed"].items())


def _suspect(row: dict[str, Any], units: FileUnits) -> str:
    if "stated" not in row:
        return str(row["effect"])
    return f"{row['effect']}, other than {units.channel(row['where'], row['unit']).text(row['stated'])}"


def _diff(found: Found) -> str:
    lines = difflib.unified_diff(found.rig.text.splitlines(), found.improved_text.splitlines(), "rig file", "improved", lineterm="", n=1)
    text = "\n".join(lines) or "The rig file is unchanged."
    return f"<h2>Improved rig file</h2><pre>{escape(text)}</pre>"


def _inputs(found: Found) -> str:
    rows = [[i["file"], i["sha256"]] for i in found.content["inputs"]]
    return f"<h2>Inputs</h2>{table(['file', 'SHA-256'], rows)}{paragraph(found.content['software'])}"
